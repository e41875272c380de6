//! Samples of a posterior for the page.

use super::super::data::{DataItem, Floats, Level, Meta, Named, Posterior, ReportData, Sampled, Verdict};
use retune::catalogue::counted;
use retune::data::{Origin, TestData};
use retune::model::{Model, ParametricModel};
use retune::update::{self, marginals, sampled_values};

/// Samples of each parameter that travel with the page.
const MOST_SAMPLES: usize = 4000;

/// The report of sampling: what the data say of each free parameter and of each two of them.
pub fn of_posterior(model: &Model, test: &TestData, found: &update::Sampled) -> ReportData {
    let (posterior, parameters) = (&found.posterior, model.parameters());
    let values = sampled_values(posterior, model);
    let step = values.nrows().div_ceil(MOST_SAMPLES).max(1);
    let one = |(k, m): (usize, update::Marginal)| {
        let bounds = parameters.index_of(&m.name).and_then(|i| {
            let p = parameters.get(i);
            p.bounds.map(|b| b.map(|v| p.display(v)))
        });
        let column = values.column(k);
        let [lower, upper] = bounds.unwrap_or([column.min(), column.max()]);
        Sampled {
            name: m.name,
            unit: if m.unit == "1" { String::new() } else { m.unit },
            lower,
            upper,
            mean: m.mean,
            sd: m.sd,
            quantiles: m.quantiles,
            correlations: m.correlations,
            values: Floats::from_f64(column.iter().step_by(step).copied()),
        }
    };
    let shown: Vec<Sampled> = marginals(posterior, model).into_iter().enumerate().map(one).collect();
    let mut note = format!(
        "{} and {}; {:.0} % of the last steps accepted",
        counted(posterior.n_stages, "stage"),
        counted(posterior.evaluations as usize, "evaluation"),
        100.0 * posterior.acceptance
    );
    if !found.peaks.is_empty() {
        let shares: Vec<String> = found.peaks.iter().map(|p| format!("{:.0} %", 100.0 * p.share)).collect();
        note += &format!(
            "; {} peaks with nothing probable between them, of {} of the samples: means and standard deviations are of all together",
            found.peaks.len(),
            shares.join(", ")
        );
    }
    let sharp = |p: &&Sampled| {
        let range = p.upper - p.lower;
        range > 0.0 && p.quantiles[4] - p.quantiles[0] < 0.5 * range
    };
    let n_sharp = shown.iter().filter(sharp).count();
    let data_items = test.modes.iter().map(|m| &m.origin).fold(Vec::new(), |mut all: Vec<DataItem>, origin| {
        let (Origin::Measured(source) | Origin::Synthetic(source)) = origin;
        let item =
            DataItem { name: "frequencies and shapes".into(), origin: origin.word().into(), source: source.clone() };
        if !all.contains(&item) {
            all.push(item);
        }
        all
    });
    ReportData {
        meta: Meta {
            tests: vec![super::test_record(test)],
            title: test.name.clone(),
            subtitle: format!("posterior of: {}", model.spec().name),
            verdict: Some(Verdict {
                sentence: format!(
                    "The data narrow {n_sharp} of {} to less than half of their range.",
                    counted(shown.len(), "parameter")
                ),
                number: format!("{:.2} ± {:.2}", posterior.log_evidence, posterior.log_evidence_se),
                number_label: "ln of the evidence of the model over its bounds, with its standard error".into(),
                level: Level::Neutral,
            }),
            versions: vec![Named::new("retune", env!("CARGO_PKG_VERSION"))],
            data_items,
            ..Meta::default()
        },
        posterior: Some(Posterior {
            parameters: shown,
            samples: posterior.samples.len(),
            log_evidence: posterior.log_evidence,
            log_evidence_se: posterior.log_evidence_se,
            note,
        }),
        ..ReportData::default()
    }
}
