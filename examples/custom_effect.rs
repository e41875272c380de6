//! An effect of your own: liquid left in a tank, wherever the file has a point mass.
//!
//! `cargo run --example custom_effect` places it on the flying wing beside the built-in effects and prints the edit.

use retune::effect::{About, Candidate, Context, Edit, Effect, Effects, NewParameter, Patch, PatchError};
use retune::effect::{Location, LocationKind, PartKind, Structure, candidates, conformance};
use retune::element::Dof;
use retune::model::{Registry, load, spec::MassSpec};
use retune::units::Scalar;

/// Liquid in a tank at a node: the part that does not slosh adds mass, and no moment of inertia.
#[derive(Debug)]
struct TankLiquid;

impl Effect for TankLiquid {
    fn name(&self) -> &'static str {
        "tank-liquid"
    }

    fn about(&self) -> About {
        About {
            summary: "Liquid left in a tank at a node: mass without a moment of inertia of its own.",
            signature: "Lowers modes with motion of the tank; repeats at another filling show another size.",
            formulation: "M gains m u² at the node of the tank; m = 0 leaves it.",
            confusable: &["point-mass"],
            references: &["H. N. Abramson, The Dynamic Behavior of Liquids in Moving Containers, 1966"],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        // Tanks are where the file has a mass already.
        let tanks = structure.parts().iter().filter(|p| p.kind == PartKind::Mass);
        let moves = |e: usize| structure.moves(e, Dof::Uz);
        let places = tanks.filter(|p| moves(p.elements[0]));
        places.map(|p| Location::new(LocationKind::Mass, vec![p.name.clone()])).collect()
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let parts = structure.parts_at(self.name(), at)?;
        let node = structure.model().elements()[parts[0].elements[0]].nodes[0];
        let name = format!("tank_liquid.{}", at.place());
        let mass = NewParameter {
            name: format!("{name}.mass"),
            unit: "kg".to_string(),
            neutral: 0.0,
            typical: 0.05,
            bounds: [0.0, 0.5],
            grid: Vec::new(),
            description: format!("liquid in the tank at {}", at.place()),
        };
        let entry = MassSpec {
            node: Some(structure.node_name(node).to_string()),
            mass: Scalar::parse(&mass.name).ok(),
            ..MassSpec::default()
        };
        Ok(Patch { edits: vec![Edit::AddParameter(mass), Edit::AddMass { name, entry }] })
    }
}

fn main() {
    let text = include_str!("../models/bff.yaml");
    let (model, _, _) = load(text, &Registry::builtin()).expect("the model is sound");
    let effects = Effects::builtin().with(&TankLiquid);
    let all = candidates(&model, &effects, &Context::default());
    let mine: Vec<&Candidate> = all.iter().filter(|c| c.effect.name() == "tank-liquid").collect();
    println!("{} candidates, {} of them tanks; the first as an edit of the file:", all.len(), mine.len());
    print!("{}", mine[0].patch.to_yaml());
    // The contract of every effect, neutral start and undo among it, on a model of your own.
    let own = Effects::none().with(&TankLiquid);
    let failures = conformance::check(&own, text, &Registry::builtin(), &Context::default());
    assert!(failures.is_empty(), "{failures:?}");
}

#[test]
fn it_runs() {
    main();
}
