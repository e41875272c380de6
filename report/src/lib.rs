//! What people look at: one self-contained page, figures for a paper, files for ParaView, tables for a terminal.
//!
//! [`ReportData`] holds everything that a report shows, as plain data; [`html`] makes the page, [`json`] the data file,
//! [`figures`] single pictures as SVG, [`paraview`] the files of model and modes, [`text`] what a terminal prints, and [`answer`] what `--json` does.
//! Numbers come in finished, and every output shows the same ones; [`live`] alone makes a model on which the page itself computes.
//!
//! The page is a script and a style sheet, built from TypeScript in `web/` at development time and embedded here; no
//! user needs that build. Start reading at [`data`] for the content and at `web/src/main.ts` for the page.

pub mod answer;
mod build;
pub mod data;
mod html;
mod live;
mod svg;
pub mod text;
mod vtk;

#[cfg(test)]
mod fixture;

pub use build::{
    Case, LearningStep, LearntParameter, add_before, add_diagnosis, add_learning, add_parameters, add_responses,
    add_tests, assess_for_report, assess_paired, diagnosis, learning_steps, misfit_before_any_fit, of_comparison,
    of_identification, of_learning, of_posterior, of_update, steps,
};
pub use data::{ReportData, ReportError};
pub use html::{html, json};
pub use live::{NotLive, Tested, add_live, add_live_of_learning, add_versions, live, live_tests};
pub use svg::{Figure, figures, response_figure};
pub use vtk::{VtkFile, paraview};
