//! The flagship against its audited reference values.
use retune::modal::{self, SolveOptions};
use retune::model::{self, ParametricModel, Registry};

#[test]
fn probe() {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/models/bff.yaml")).unwrap();
    let (model, warnings, map) = model::load(&text, &Registry::builtin()).unwrap_or_else(|p| panic!("{}", p.iter().map(|p| p.render("bff.yaml")).collect::<Vec<_>>().join("\n")));
    for w in warnings { println!("{}", w.render("bff.yaml")); }
    let theta = model.parameters().nominal();
    println!("{:?}", model.mass_properties(&theta).unwrap());
    let s = model.assemble(&theta).unwrap();
    println!("n {} affine {}", s.mass.nrows(), model.affine().is_some());
    let modes = modal::solve(&s.stiffness, &s.mass, &model.dof_map().rigid_motions(), SolveOptions { n_elastic: 9, shift: None }).unwrap();
    println!("{:?} rigid {}", modes.frequencies_hz(), modes.n_rigid);
    let l = model::lint(&model).unwrap();
    for w in map.place(l.warnings).iter().chain(&map.place(l.errors)) { println!("{}", w.render("bff.yaml")); }
    println!("{} {}", l.n_rigid_body_modes, l.n_mechanisms);
}
