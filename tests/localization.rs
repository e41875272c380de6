//! A stiffness loss in one member is found, wherever it is; a right model shows nothing.

use retune::correlation::{PairBy, PairingOptions};
use retune::data::{TestData, read_test};
use retune::model::{Model, ParametricModel, Registry, load};
use retune::objective::Comparison;
use retune::update::{PlacesOptions, TwinOptions, assess, node_sensors, places, twin_modes};
use std::path::Path;

const PAIRING: PairingOptions =
    PairingOptions { by: PairBy::Mac, min_mac: 0.0, frequency_window: f64::INFINITY, same_family_only: false };

fn text(file: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("models").join(file);
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn model(file: &str) -> Model {
    load(&text(file), &Registry::builtin()).unwrap_or_else(|p| panic!("{p:?}")).0
}

#[test]
#[ignore]
fn experiment() {
    for (file, sensors, n_modes, fsd) in [
        ("bff_truth.yaml", Some("bff_gvt.yaml"), 6, 0.002),
        ("bff.yaml", Some("bff_gvt.yaml"), 6, 0.002),
        ("frame.yaml", None, 6, 0.002),
        ("two_storey_frame.yaml", None, 6, 0.002),
        ("cantilever.yaml", None, 5, 0.002),
        ("garteur.yaml", None, 9, 0.002),
    ] {
        let base = model(file);
        let sensors = match sensors {
            Some(t) => read_test(&text(t)).unwrap().0.sensors,
            None => node_sensors(&base),
        };
        let theta = base.parameters().nominal();
        let members: Vec<String> = retune::update::member_stiffnesses(&base, &theta).unwrap().into_iter().map(|m| m.name).collect();
        let errors = [0.01, 0.03, 0.1, 0.3, 1.0];
        println!("{file}: {} dofs {} members {} sensors", base.dof_map().n_dof(), members.len(), sensors.len());
        for damaged in std::iter::once(None).chain(members.iter().map(Some)) {
            let truth = match damaged {
                None => base.clone(),
                Some(m) => {
                    let mut found = None;
                    for keys in ["{E: 0.8, G: 0.8}", "{EIy: 0.8, GJ: 0.8}", "{EIy: 0.8}", "{E: 0.8}"] {
                        if let Ok(spec) = base.spec().overlaid(&format!("overrides: {{{m}: {{scale: {keys}}}}}"))
                            && let Ok((model, _)) = Model::new(spec, &Registry::builtin()) { found = Some(model); break; }
                    }
                    let Some(f) = found else { println!("  {m}: no override"); continue };
                    f
                }
            };
            let mut hits = vec![[0usize; 4]; errors.len()];
            let mut single = [0usize; 3];
            let mut out = vec![0usize; errors.len()];
            for seed in 0..10 {
                let options = TwinOptions { n_modes, frequency_noise: fsd, shape_noise: 0.01, seed, ..Default::default() };
                let test = twin_modes(&truth, &theta, &sensors, &options, "t").unwrap();
                let c = Comparison::new(&base, &test, PAIRING).unwrap();
                let a = assess(&c, &theta).unwrap();
                for (k, e) in errors.iter().enumerate() {
                    let p = places(&base, &c, &a, PlacesOptions { relative_error: *e }).unwrap();
                    out[k] += usize::from(p.by_element.stands_out(0.01));
                    if let Some(m) = damaged {
                        let l = &p.by_element.places;
                        let rank = |key: &dyn Fn(&retune::correlation::Place) -> f64| {
                            let own = key(l.iter().find(|p| p.name == *m).unwrap());
                            l.iter().filter(|p| key(p) > own).count()
                        };
                        hits[k][0] += usize::from(l.iter().position(|p| p.name == *m).unwrap() < 2);
                        hits[k][1] += usize::from(rank(&|p| p.energy / p.noise_mean) < 2);
                        hits[k][2] += usize::from(rank(&|p| p.relative_energy) < 2);
                        hits[k][3] += usize::from(rank(&|p| p.energy) < 2);
                    }
                    if k == 0 {
                        single[1] += usize::from(p.changes_by_element.p_family < 0.01);
                        if let Some(m) = damaged {
                            single[0] += usize::from(p.changes_by_element.changes.iter().position(|p| p.name == *m).unwrap() < 2);
                            single[2] += usize::from(p.changes_by_element.changes[0].name == *m);
                        }
                    }
                }
            }
            println!("  {:<16} single {single:?} energy out {out:?} hits {hits:?}", damaged.map_or("-", |s| s.as_str()));
        }
    }
}
