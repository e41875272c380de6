//! Materials: density and elastic constants.

use super::elastic::{Elastic, Material};
use super::importer::{Importer, Values};
use crate::system::Quantity as Q;
use retune::deck::{DataLine, DeckError, Keyword};
use retune::linalg::DMatrix;

/// Numbers of a keyword over as many lines as they need.
fn numbers(k: &Keyword<'_>, n: usize, name: &'static str) -> Result<Vec<f64>, DeckError> {
    let mut out = Vec::with_capacity(n);
    for line in k.lines().filter(|l| !l.is_empty()) {
        for i in 0..8.min(n - out.len()) {
            out.push(line.real(i, name)?);
        }
        if out.len() == n {
            return Ok(out);
        }
    }
    Err(k.error(format_args!("{n} constants are expected, and {} are given", out.len())))
}

fn positive(line: &DataLine<'_>, i: usize, name: &'static str) -> Result<f64, DeckError> {
    let value = line.real(i, name)?;
    if value > 0.0 { Ok(value) } else { Err(line.error(Some((i, name)), "it must be above zero")) }
}

/// Reads a material.
pub(super) fn read(importer: &mut Importer<'_>, keywords: &[usize]) -> Result<Material, DeckError> {
    let mut out = Material::default();
    for index in keywords {
        let k = importer.deck.keyword(*index);
        match k.name() {
            "DENSITY" => {
                let line = k.needs_line(0, "the density")?;
                let rho = line.real(0, "density")?;
                if rho < 0.0 {
                    return Err(line.error(Some((0, "density")), "it must not be negative"));
                }
                out.density = Some(rho).filter(|r| *r > 0.0);
                out.density_at = Some(*index);
                importer.only_first(&k, 1);
            }
            "ELASTIC" => {
                let (constants, is_interpolated) = elastic(importer, &k)?;
                out.elastic = Some(constants);
                // What is interpolated is not an item of the deck.
                out.elastic_at = Some(*index).filter(|_| !is_interpolated);
            }
            _ => {}
        }
    }
    Ok(out)
}

/// The constants, and whether they are between those of the deck.
fn elastic(importer: &mut Importer<'_>, k: &Keyword<'_>) -> Result<(Elastic, bool), DeckError> {
    let mut is_interpolated = false;
    let kind: String = k.label("TYPE").unwrap_or_else(|| "ISO".to_string()).split_whitespace().collect();
    let above = |values: &[f64]| {
        let ok = values.iter().all(|v| *v > 0.0);
        if ok { Ok(()) } else { Err(k.error("its moduli must be above zero")) }
    };
    let constants = match kind.as_str() {
        "ISO" | "ISOTROPIC" => {
            let constants = |line: &DataLine<'_>| {
                let (e, nu) = (positive(line, 0, "E")?, line.real_or(1, "nu", 0.0)?);
                if nu > -1.0 && nu < 0.5 {
                    Ok((e, nu))
                } else {
                    Err(line.error(Some((1, "nu")), "Poisson's ratio must be above -1 and below 0.5"))
                }
            };
            let (mut e, mut nu) = constants(&k.needs_line(0, "E and nu")?)?;
            let is_table = k.n_lines() > 1 && k.parameter("DEPENDENCIES").is_none();
            match is_table.then(|| importer.temperature()).flatten() {
                Some(at) => {
                    is_interpolated = true;
                    let rows: Vec<(f64, (f64, f64))> = k
                        .lines()
                        .filter(|l| !l.is_empty())
                        .map(|l| Ok((l.real_or(2, "temperature", 0.0)?, constants(&l)?)))
                        .collect::<Result<_, DeckError>>()?;
                    (e, nu) = interpolated(&rows, at).ok_or_else(|| k.error("its temperatures must ascend"))?;
                    importer.report.note(format!(
                        "elastic constants that depend on temperature are those at {at}, the deck's own"
                    ));
                }
                None => importer.only_first(k, 1),
            }
            Elastic::Isotropic { e, nu }
        }
        "ENGINEERINGCONSTANTS" => {
            importer.only_first(k, 2);
            let c = numbers(k, 9, "constant")?;
            above(&[c[0], c[1], c[2], c[6], c[7], c[8]])?;
            Elastic::Orthotropic { e: [c[0], c[1], c[2]], nu: [c[3], c[4], c[5]], g: [c[6], c[7], c[8]] }
        }
        "LAMINA" => {
            importer.only_first(k, 1);
            let c = numbers(k, 6, "constant")?;
            above(&[c[0], c[1], c[3], c[4], c[5]])?;
            Elastic::Lamina { e: [c[0], c[1]], nu: c[2], g: [c[3], c[4], c[5]] }
        }
        "ORTHO" | "ORTHOTROPIC" => {
            importer.only_first(k, 2);
            // D1111 D1122 D2222 D1133 D2233 D3333 D1212 D1313 D2323: the compliance is the inverse.
            let c = numbers(k, 9, "constant")?;
            let d = DMatrix::from_row_slice(3, 3, &[c[0], c[1], c[3], c[1], c[2], c[4], c[3], c[4], c[5]]);
            let s = d.try_inverse().filter(|s| (0..3).all(|i| s[(i, i)] > 0.0 && s[(i, i)].is_finite()));
            let s =
                s.ok_or_else(|| k.error("its stiffnesses are those of no material: not every stress stores energy"))?;
            above(&c[6..9])?;
            let e: [f64; 3] = std::array::from_fn(|i| 1.0 / s[(i, i)]);
            Elastic::Orthotropic {
                e,
                nu: [-s[(0, 1)] * e[0], -s[(0, 2)] * e[0], -s[(1, 2)] * e[1]],
                g: [c[6], c[7], c[8]],
            }
        }
        other => {
            return Err(k.error(format_args!(
                "elastic constants of the type {other} are not read; known are ISOTROPIC, ENGINEERING CONSTANTS, ORTHOTROPIC, LAMINA"
            )));
        }
    };
    Ok((constants, is_interpolated))
}

/// Constants of a table at a temperature, linear between its rows and those of its ends beyond; `None` where temperatures do not ascend.
fn interpolated(rows: &[(f64, (f64, f64))], at: f64) -> Option<(f64, f64)> {
    if !rows.is_sorted_by(|a, b| a.0 < b.0) {
        return None;
    }
    let next = rows.partition_point(|row| row.0 < at);
    if next == 0 || next == rows.len() {
        return rows.get(next.saturating_sub(1)).map(|row| row.1);
    }
    let ((t0, a), (t1, b)) = (rows[next - 1], rows[next]);
    let s = (at - t0) / (t1 - t0);
    Some((a.0 + s * (b.0 - a.0), a.1 + s * (b.1 - a.1)))
}

impl Importer<'_> {
    /// The temperature of all nodes, where the deck states one: that of the last step up to the chosen one, else the initial one.
    fn temperature(&self) -> Option<f64> {
        let last = self.chosen_step();
        let mut step = None;
        let mut at = None;
        for k in self.deck.keywords() {
            let is_initial = k.name() == "INITIALCONDITIONS" && k.label("TYPE").is_some_and(|t| t == "TEMPERATURE");
            if k.name() == "STEP" {
                // What stands behind the step that is read comes later.
                if step.is_some() && step == last {
                    break;
                }
                step = Some(step.map_or(0, |s: usize| s + 1));
            }
            if !(is_initial || k.name() == "TEMPERATURE") {
                continue;
            }
            let values: Option<Vec<f64>> =
                k.lines().filter(|l| !l.is_empty()).map(|l| l.real(1, "temperature").ok()).collect();
            let values = values?;
            let first = *values.first()?;
            // What differs from node to node is no one temperature.
            at = Some(first).filter(|t| values.iter().all(|v| (v - t).abs() <= 1e-3 * t.abs().max(1.0)));
        }
        at
    }

    /// Says that constants at other temperatures are left out.
    pub(super) fn only_first(&mut self, k: &Keyword<'_>, lines: usize) {
        if k.n_lines() > lines {
            self.report.note("of materials that depend on temperature or fields the first values are taken");
        }
    }

    /// That a section's density is that of its material.
    pub(super) fn bind_density(&self, material: &Material) {
        if let Some(at) = material.density_at {
            self.bind("density", (at, 0, 0), Q::Density);
        }
    }

    /// The material of a section.
    pub(super) fn material(&self, k: &Keyword<'_>) -> Result<Material, DeckError> {
        self.material_of(k, &k.needs("MATERIAL")?)
    }

    pub(super) fn material_of(&self, k: &Keyword<'_>, name: &str) -> Result<Material, DeckError> {
        let found = self.materials.get(name);
        found.copied().ok_or_else(|| {
            let suggestion = retune::catalogue::did_you_mean(name, self.materials.keys().map(String::as_str));
            k.error(format_args!("there is no material `{name}`{suggestion}"))
        })
    }

    /// Elastic constants of a section of solids or shells.
    pub(super) fn elastic(
        &self,
        k: &Keyword<'_>,
        material: &Material,
        is_shell: bool,
        values: &mut Values,
    ) -> Result<(), DeckError> {
        // Constants of a stiffness matrix are not items of the deck.
        let computed = material.elastic_at.is_some_and(|k| {
            self.deck.keyword(k).label("TYPE").is_some_and(|t| t.starts_with("ORTHO") || t.starts_with("ANISO"))
        });
        let at = material.elastic_at.filter(|_| !computed);
        let mut put = |key: &str, item: usize, value: f64, q: Q| {
            values.push((key.to_string(), self.with(value, q)));
            if let Some(at) = at {
                self.bind(key, (at, item / 8, item % 8), q);
            }
        };
        match material.elastic {
            None => return Err(k.error("its material has no *ELASTIC")),
            Some(Elastic::Isotropic { e, nu }) => {
                put("E", 0, e, Q::Stress);
                put("nu", 1, nu, Q::Number);
            }
            Some(Elastic::Lamina { e, nu, g }) => {
                if !is_shell {
                    return Err(k.error("a solid needs ENGINEERING CONSTANTS, and LAMINA are those of a sheet"));
                }
                put("E1", 0, e[0], Q::Stress);
                put("E2", 1, e[1], Q::Stress);
                put("nu12", 2, nu, Q::Number);
                for (i, (key, value)) in ["G12", "G13", "G23"].into_iter().zip(g).enumerate() {
                    put(key, 3 + i, value, Q::Stress);
                }
            }
            Some(Elastic::Orthotropic { e, nu, g }) => {
                for (i, (key, value)) in ["E1", "E2", "E3"].into_iter().zip(e).enumerate() {
                    if !(is_shell && i == 2) {
                        put(key, i, value, Q::Stress);
                    }
                }
                for (i, (key, value)) in ["nu12", "nu13", "nu23"].into_iter().zip(nu).enumerate() {
                    if !(is_shell && i > 0) {
                        put(key, 3 + i, value, Q::Number);
                    }
                }
                for (i, (key, value)) in ["G12", "G13", "G23"].into_iter().zip(g).enumerate() {
                    put(key, 6 + i, value, Q::Stress);
                }
            }
        }
        if let Some(rho) = material.density {
            values.push(("density".to_string(), self.with(rho, Q::Density)));
            self.bind_density(material);
        }
        Ok(())
    }
}
