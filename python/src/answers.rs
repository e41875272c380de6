//! Results as the library gives them, kept for what is asked of them later.

use crate::arrays;
use crate::error::Wrong;
use crate::model::Model;
use crate::page::{Made, sign_call};
use crate::running::on_pool;
use crate::test::{Frfs, Test, TestSource};
use crate::tested::{Tested, others};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use retune::correlation::CriteriaProfile;
use retune::data::{TestData, joined};
use retune::effect::set_parameter_values;
use retune::model::{self, ParametricModel as _};
use retune::update::{self, Agreement, HowToPair, marginals, sampled_values};
use retune_report::{
    Case, add_diagnosis, add_live, add_live_of_learning, add_tests, answer, assess_paired, html, of_comparison,
    of_identification, of_learning, of_posterior, of_update,
};
use serde_json::json;
use std::sync::Arc;

/// Notes and warnings as (category, text).
type Remarks = Vec<(&'static str, String)>;

fn remarks_of(all: &[Tested]) -> Remarks {
    all.iter().flat_map(|t| t.remarks.clone()).collect()
}

fn warnings_of(all: &[Tested]) -> impl Iterator<Item = String> + '_ {
    all.iter().flat_map(|t| &t.remarks).filter(|r| r.0 == "warning").map(|r| r.1.clone())
}

/// A model beside its tests.
#[pyclass(frozen, module = "retune._core")]
pub(crate) struct Compared {
    pub(crate) parts: Vec<Agreement>,
    pub(crate) all: Vec<Tested>,
    pub(crate) profile: Option<CriteriaProfile>,
    pub(crate) how: HowToPair,
    pub(crate) made: Made,
}

#[pymethods]
impl Compared {
    fn remarks(&self) -> Remarks {
        remarks_of(&self.all)
    }

    fn json(&self) -> String {
        let one = |parts: &Agreement| answer::comparison(parts, self.profile.as_ref());
        match self.parts.as_slice() {
            [only] => one(only).to_string(),
            several => json!({"tests": several.iter().map(one).collect::<Vec<_>>()}).to_string(),
        }
    }

    fn passed(&self) -> bool {
        self.parts.iter().all(|p| p.judgement.as_ref().is_none_or(|j| j.passed))
    }

    fn page(&self, py: Python<'_>) -> PyResult<String> {
        let first = &self.all[0];
        let work = || {
            let data = compared(first, &self.how)?;
            self.made.page(data)
        };
        Ok(on_pool(py, work)?)
    }
}

/// The report of a comparison at the estimates.
pub(crate) fn compared(tested: &Tested, how: &HowToPair) -> Result<retune_report::ReportData, Wrong> {
    let model = tested.model.file()?;
    let assessment = assess_paired(model, &model.parameters().nominal(), &tested.test, how)?;
    let mut data = of_comparison(Case { model, test: &tested.test, assessment: &assessment })?;
    data.meta.warnings.extend(warnings_of(std::slice::from_ref(tested)));
    Ok(data)
}

/// A fit.
#[pyclass(frozen, module = "retune._core")]
pub(crate) struct Updated {
    pub(crate) update: update::Update,
    pub(crate) all: Vec<Tested>,
    pub(crate) how: HowToPair,
    pub(crate) made: Made,
}

#[pymethods]
impl Updated {
    fn remarks(&self) -> Remarks {
        let mut all = remarks_of(&self.all);
        all.extend(self.update.optimum.warnings.iter().map(|w| ("warning", w.clone())));
        all
    }

    fn json(&self) -> String {
        let tests: Vec<&TestData> = self.all.iter().map(|t| &t.test).collect();
        answer::updated(&self.update, &tests).to_string()
    }

    /// All parameters at the optimum, SI, in the order of the model.
    fn theta<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        arrays::vector(py, self.update.parameters.iter().map(|p| p.after_si).collect())
    }

    /// Correlations of the free parameters; NaN where one has no standard deviation.
    fn correlations<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        arrays::matrix(py, self.update.uncertainty.correlations.clone())
    }

    /// Evaluations and best cost after each improvement.
    fn history<'py>(&self, py: Python<'py>) -> (Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<f64>>) {
        let history = &self.update.optimum.history;
        let evaluations = history.iter().map(|h| h.evaluations as i64).collect();
        (arrays::vector(py, evaluations), arrays::vector(py, history.iter().map(|h| h.cost).collect()))
    }

    fn is_converged(&self) -> bool {
        self.update.optimum.termination.is_converged()
    }

    /// The model file with the values of the optimum.
    fn model(&self, py: Python<'_>) -> PyResult<Model> {
        let source = self.made.source()?;
        let edit = || {
            let free = self.update.parameters.iter().filter(|p| p.lower.is_some());
            let values: Vec<(&str, f64)> = free.map(|p| (p.name.as_str(), p.after_si)).collect();
            let text = set_parameter_values(&source.text, &values)?;
            source.edited(text)
        };
        Ok(Model(Arc::new(on_pool(py, edit)?)))
    }

    fn page(&self, py: Python<'_>) -> PyResult<String> {
        let (first, u) = (&self.all[0], &self.update);
        let work = || {
            let model = first.model.file()?;
            let mut data = of_update(model, &first.test, u)?;
            let case = Case { model, test: &first.test, assessment: &u.after };
            add_live(&mut data, case, &others(&self.all)?, &self.how, Some(model), &[]);
            add_tests(&mut data, &self.all.iter().map(|t| &t.test).collect::<Vec<_>>());
            data.meta.warnings.extend(u.uncertainty.remarks.iter().cloned());
            if self.all.len() > 1 {
                let n = self.all.len();
                data.meta.warnings.push(format!("The fit is to {n} tests; modes, pairs and steps show the first."));
            }
            data.meta.warnings.extend(u.optimum.warnings.iter().map(ToString::to_string));
            self.made.page(data)
        };
        Ok(on_pool(py, work)?)
    }
}

/// A posterior.
#[pyclass(frozen, module = "retune._core")]
pub(crate) struct Sampled {
    pub(crate) sampled: update::Sampled,
    pub(crate) all: Vec<Tested>,
    pub(crate) made: Made,
}

#[pymethods]
impl Sampled {
    fn remarks(&self) -> Remarks {
        remarks_of(&self.all)
    }

    fn json(&self) -> String {
        answer::sampled(&self.sampled, self.all[0].model.parametric()).to_string()
    }

    /// Names and units of the free parameters.
    fn names(&self) -> Vec<(String, String)> {
        let all = marginals(&self.sampled.posterior, self.all[0].model.parametric());
        all.into_iter().map(|m| (m.name, m.unit)).collect()
    }

    /// (n_samples x n_free), in the units of the parameters.
    fn samples<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        arrays::matrix(py, sampled_values(&self.sampled.posterior, self.all[0].model.parametric()))
    }

    fn page(&self, py: Python<'_>) -> PyResult<String> {
        let first = &self.all[0];
        let work = || {
            let mut data = of_posterior(first.model.file()?, &first.test, &self.sampled);
            data.meta.warnings.extend(warnings_of(&self.all));
            add_tests(&mut data, &self.all.iter().map(|t| &t.test).collect::<Vec<_>>());
            self.made.page(data)
        };
        Ok(on_pool(py, work)?)
    }

    /// Cost of each sample.
    fn costs<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        arrays::vector(py, self.sampled.posterior.costs.clone())
    }
}

/// What is missing.
#[pyclass(frozen, module = "retune._core")]
pub(crate) struct Diagnosed {
    pub(crate) diagnosis: retune_diagnosis::Diagnosis,
    pub(crate) all: Vec<Tested>,
    pub(crate) how: HowToPair,
    pub(crate) made: Made,
}

#[pymethods]
impl Diagnosed {
    fn remarks(&self) -> Remarks {
        remarks_of(&self.all)
    }

    fn json(&self) -> PyResult<String> {
        Ok(serde_json::to_string(&self.diagnosis).map_err(Wrong::from)?)
    }

    fn page(&self, py: Python<'_>) -> PyResult<String> {
        let first = &self.all[0];
        let work = || {
            let mut data = compared(first, &self.how)?;
            let tests: Vec<&TestData> = self.all.iter().map(|t| &t.test).collect();
            let model = first.model.file()?;
            add_diagnosis(&mut data, &self.diagnosis, model, &joined(&tests).test);
            let assessment = assess_paired(model, &model.parameters().nominal(), &first.test, &self.how)?;
            let case = Case { model, test: &first.test, assessment: &assessment };
            add_live(&mut data, case, &others(&self.all)?, &self.how, None, &self.diagnosis.hypotheses);
            add_tests(&mut data, &tests);
            data.meta.warnings.extend(warnings_of(&self.all[1..]));
            self.made.page(data)
        };
        Ok(on_pool(py, work)?)
    }
}

/// What was learnt.
#[pyclass(frozen, module = "retune._core")]
pub(crate) struct Learned {
    pub(crate) learned: retune_diagnosis::Learned,
    pub(crate) all: Vec<Tested>,
    pub(crate) made: Made,
}

#[pymethods]
impl Learned {
    fn remarks(&self) -> Remarks {
        remarks_of(&self.all)
    }

    fn json(&self) -> PyResult<String> {
        Ok(answer::learned(&self.learned, &[]).map_err(Wrong::from)?.to_string())
    }

    /// The model of every step.
    fn models(&self, py: Python<'_>) -> PyResult<Vec<Model>> {
        let source = self.made.source()?;
        let edit = || {
            let texts = self.learned.model_texts(&source.text)?;
            texts.into_iter().map(|text| Ok(Model(Arc::new(source.edited(text)?)))).collect::<Result<Vec<_>, Wrong>>()
        };
        Ok(on_pool(py, edit)?)
    }

    /// The tests without the faults that were found.
    fn tests(&self) -> PyResult<Vec<Test>> {
        let one = |data: &TestData| Ok(Test(Arc::new(TestSource::written(data)?)));
        Ok(self.learned.tests.iter().map(one).collect::<Result<Vec<_>, Wrong>>()?)
    }

    fn page(&self, py: Python<'_>) -> PyResult<String> {
        let mut cases: Vec<(&model::Model, &TestData)> = Vec::with_capacity(self.all.len());
        for t in &self.all {
            cases.push((t.model.file()?, &t.test));
        }
        let work = || {
            let mut data = of_learning(&cases, &self.learned)?;
            add_live_of_learning(&mut data, &cases, &self.learned);
            add_tests(&mut data, &self.all.iter().map(|t| &t.test).collect::<Vec<_>>());
            data.meta.warnings.extend(warnings_of(&self.all));
            self.made.page(data)
        };
        Ok(on_pool(py, work)?)
    }
}

/// Modes from measurements.
#[pyclass(frozen, module = "retune._core")]
pub(crate) struct Identified {
    pub(crate) identified: update::Identified,
    pub(crate) remarks: Remarks,
}

#[pymethods]
impl Identified {
    fn remarks(&self) -> Remarks {
        self.remarks.clone()
    }

    fn json(&self) -> String {
        answer::identified(&self.identified).to_string()
    }

    /// The test that a model can be compared with.
    fn test(&self) -> PyResult<Test> {
        if let Some(lacks) = &self.identified.test_lacks {
            return Err(Wrong::from(lacks.clone()).into());
        }
        Ok(Test(Arc::new(TestSource::written(&self.identified.test)?)))
    }

    fn page(&self, py: Python<'_>) -> PyResult<String> {
        let work = || {
            let Some(mut data) = of_identification(&self.identified)? else {
                return Err(Wrong::text(
                    "a page shows how modes come from functions with a force; these measurements have none",
                ));
            };
            data.meta.warnings.extend(self.identified.remarks.iter().map(|r| r.text().to_string()));
            sign_call(&mut data, "retune.identify", None);
            Ok::<_, Wrong>(html(&data)?)
        };
        Ok(on_pool(py, work)?)
    }

    /// The functions, with the points that roved as responses.
    fn frfs(&self) -> Option<Frfs> {
        match &self.identified.way {
            update::Way::Functions { frfs, .. } => Some(Frfs::new(frfs.clone(), self.identified.is_synthetic)),
            update::Way::Held { .. } | update::Way::Peaks(_) => None,
        }
    }
}

/// A synthetic test.
#[pyclass(frozen, module = "retune._core")]
pub(crate) struct Twin {
    pub(crate) json: String,
    pub(crate) test: Option<Arc<TestSource>>,
    pub(crate) frfs: Option<Arc<retune::data::FrfSet>>,
}

#[pymethods]
impl Twin {
    fn json(&self) -> &str {
        &self.json
    }

    fn test(&self) -> Option<Test> {
        self.test.clone().map(Test)
    }

    fn frfs(&self) -> Option<Frfs> {
        self.frfs.as_ref().map(|set| Frfs { set: Arc::clone(set), geometry: None, is_synthetic: true })
    }
}
