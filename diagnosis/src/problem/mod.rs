//! What is solved: structures against their tests as one least-squares problem with priors, its optimum, and the evidence of that.
//!
//! `scene` poses it, `rows` are its residuals, `race` finds the optimum, `fit` is what it looks like, `evidence` weighs it; `missed` finds modes that the test should have seen, `mesh`
//! what the mesh falsifies. `changed` puts effects into a scene, `changes` keeps those of large models. `work` counts.

pub(crate) mod changed;
pub(crate) mod changes;
pub(crate) mod evidence;
pub(crate) mod fit;
pub(crate) mod mesh;
pub(crate) mod missed;
pub(crate) mod prior;
pub(crate) mod race;
pub(crate) mod rows;
pub(crate) mod scene;
pub(crate) mod work;
