//! Sections of members: PBAR, PBARL, PBEAM, PBEAML, PROD, PTUBE.

mod shape;
mod stations;

use super::importer::{Importer, Values};
use super::materials::{density, for_members};
use super::{CardRule, refused, used};
use crate::report::ImportReport;
use crate::system::Quantity as Q;
use crate::text::{computed, with_unit};
use retune::deck::{Card, DeckError};
use std::f64::consts::PI;

pub(super) const CARDS: &[CardRule] = &[
    used("PBAR", "sections"),
    used("PBARL", "sections"),
    used("PBEAM", "sections"),
    used("PBEAML", "sections"),
    used("PROD", "sections").up_to(7),
    used("PTUBE", "sections").up_to(7),
    refused("PBCOMP", "composite beams are not read; give a PBEAM"),
    refused("PBEND", "curved beams are not read"),
    refused("PBRSECT", "arbitrary sections are not read; give the PBAR that the solver made of it"),
    refused("PBMSECT", "arbitrary sections are not read; give the PBEAM that the solver made of it"),
    refused("PBEAM3", "three-noded beams are not read"),
];

/// The section of a member.
pub(super) struct MemberSection {
    pub name: String,
    /// From the axes of the deck to the principal axes that the section is written in, rad.
    pub turn: f64,
}

/// What a property says in the deck's numbers.
#[derive(Debug, Clone, Default)]
struct Given {
    /// A, I1, I2, I12, J, NSM.
    numbers: [f64; 6],
    /// Fields of these; `None` where they were computed.
    fields: [Option<(usize, &'static str)>; 6],
    /// Shear factors along y and z; zero means no shear flexibility.
    shear: [f64; 2],
    shear_fields: [Option<(usize, &'static str)>; 2],
    /// Inertia of the non-structural mass about x per length.
    nsi: f64,
    /// Neutral axis and centre of the non-structural mass, (y, z) from the shear centre.
    neutral: [f64; 2],
    nsm_at: [f64; 2],
}

impl Given {
    /// Offsets and shear factors along principal axes, `turn` from those of the deck.
    fn turn(&mut self, turn: f64, report: &mut ImportReport) {
        let (s, c) = turn.sin_cos();
        let along = |[y, z]: [f64; 2]| [c * y + s * z, c * z - s * y];
        (self.neutral, self.nsm_at) = (along(self.neutral), along(self.nsm_at));
        if self.shear[0] != self.shear[1] && self.shear.iter().all(|k| *k >= 0.0) {
            // Flexibilities 1/k turn as a tensor does, zero standing for none; what couples the two planes is left out.
            let inverse = |k: f64| if k > 0.0 { 1.0 / k } else { 0.0 };
            let [f, g] = self.shear.map(inverse);
            self.shear = [c * c * f + s * s * g, s * s * f + c * c * g].map(inverse);
            self.shear_fields = [None; 2];
            report.approximate("shear of sections with I12 does not couple the two principal planes");
        }
    }
}

const NAMES: [&str; 6] = ["A", "I1", "I2", "I12", "J", "NSM"];

/// The section of a bar or beam.
pub(super) fn section<'a>(
    importer: &mut Importer<'a>,
    property: &Card<'a>,
    is_beam: bool,
) -> Result<MemberSection, DeckError> {
    let given = given(importer, property)?;
    let [_, i1, i2, i12, ..] = given.numbers;
    // Principal axes: tan 2α = 2 I12 / (I1 - I2) turns the first plane to that of the larger.
    let turn = if i12 == 0.0 { 0.0 } else { 0.5 * (2.0 * i12).atan2(i1 - i2) };
    let kind = if is_beam { "beam" } else { "bar" };
    let name = importer.section(property, kind, |importer| values(importer, property, &given, turn, is_beam))?;
    Ok(MemberSection { name, turn })
}

fn given(importer: &mut Importer<'_>, property: &Card<'_>) -> Result<Given, DeckError> {
    let mut out = Given::default();
    match property.name() {
        "PBAR" => {
            let fields = [4, 5, 6, 20, 7, 8];
            for (i, (n, name)) in fields.into_iter().zip(NAMES).enumerate() {
                out.numbers[i] = property.real_or(n, name, 0.0)?;
                out.fields[i] = Some((n, name));
            }
            out.shear = [property.real_or(18, "K1", 0.0)?, property.real_or(19, "K2", 0.0)?];
            out.shear_fields = [Some((18, "K1")), Some((19, "K2"))];
        }
        "PBARL" | "PBEAML" => {
            let shape = shape::read(property)?;
            out.numbers = [shape.area, shape.i1, shape.i2, shape.i12, shape.j, shape.nsm];
            out.fields[5] = shape.nsm_field;
            out.shear = shape.shear;
            importer.report.note("properties of PBARL and PBEAML are those of the exact shape (torsion by Saint-Venant's series); the solver's own finite elements give J about 1e-3 larger");
            // Grids of a CBEAM lie on the shear centre, those of a CBAR on the centroid, whatever its section.
            if property.name() == "PBEAML" {
                out.neutral = shape.neutral;
            }
            if shape.is_tapered {
                importer.report.approximate("tapered PBEAML have the section of their first end");
            }
        }
        _ => {
            let beam = stations::read(property)?;
            out.numbers = beam.numbers;
            out.fields = beam.fields;
            out.shear = beam.shear;
            out.shear_fields = beam.shear_fields;
            (out.nsi, out.neutral, out.nsm_at) = (beam.nsi, beam.neutral, beam.nsm_at);
            if beam.is_tapered {
                importer.report.approximate("tapered PBEAM have the mean section of their stations in every element");
            }
        }
    }
    for (value, (i, name)) in out.numbers.iter().zip(NAMES.into_iter().enumerate()) {
        if *value < 0.0 && i != 3 {
            return Err(property.error(out.fields[i], format_args!("{name} is {value}; it must not be negative")));
        }
    }
    let [_, i1, i2, i12, ..] = out.numbers;
    if i12 != 0.0 && i12 * i12 >= i1 * i2 {
        return Err(property.error(out.fields[3], "I12 squared must be below I1 times I2"));
    }
    Ok(out)
}

fn values(
    importer: &mut Importer<'_>,
    property: &Card<'_>,
    given: &Given,
    turn: f64,
    is_beam: bool,
) -> Result<Values, DeckError> {
    let material = importer.material(property, 3, &["MAT1"])?;
    let mut values = Values::default();
    let (has_e, has_g) = for_members(importer, &material, &mut values)?;
    let [area, mut i1, mut i2, i12, j, nsm] = given.numbers;
    let mut given = given.clone();
    if turn != 0.0 {
        let (mean, half) = (0.5 * (i1 + i2), (0.5 * (i1 - i2)).hypot(i12));
        (i1, i2) = (mean + half, mean - half);
        given.turn(turn, &mut importer.report);
    }
    let given = &given;
    // A rigidity that is nothing is stated, so that nobody takes it for forgotten.
    let rigidities = [
        ("A", 0, area, Q::Area, has_e, "EA", "N"),
        ("Iy", 2, i2, Q::SecondMoment, has_e, "EIy", "N m2"),
        ("Iz", 1, i1, Q::SecondMoment, has_e, "EIz", "N m2"),
        ("J", 4, j, Q::SecondMoment, has_g, "GJ", "N m2"),
    ];
    for (key, i, value, quantity, has_modulus, rigidity, unit) in rigidities {
        if value > 0.0 && has_modulus {
            match given.fields[i].filter(|_| turn == 0.0 || i == 0 || i == 4) {
                Some((field, name)) => {
                    importer.put(&mut values, (key, key), (property, field, name), value, (quantity, 1.0));
                }
                None => values.items.push((key.into(), with_unit(&computed(value), importer.unit(quantity)))),
            }
        } else {
            values.items.push((rigidity.into(), format!("0 {unit}")));
            if key == "A" && value > 0.0 {
                values.items.push((key.into(), with_unit(&computed(value), importer.unit(quantity))));
            }
        }
    }
    for (i, key) in ["kappa_y", "kappa_z"].into_iter().enumerate() {
        if given.shear[i] != 0.0 && area > 0.0 && has_g {
            if given.shear[i] < 0.0 {
                return Err(property.error(given.shear_fields[i], "a shear factor must not be negative"));
            }
            match given.shear_fields[i].filter(|f| !property.is_blank(f.0)) {
                Some((field, name)) => {
                    importer.put(&mut values, (key, key), (property, field, name), given.shear[i], (Q::Number, 1.0));
                }
                None => values.items.push((key.into(), computed(given.shear[i]))),
            }
        }
    }
    let rho = if area > 0.0 { density(importer, &material, &mut values)? } else { None };
    if nsm > 0.0 {
        let key = ("added_mass_per_length", "added_mass_per_length");
        match given.fields[5] {
            Some((field, name)) => {
                importer.put(&mut values, key, (property, field, name), nsm, (Q::MassPerLength, importer.wtmass));
            }
            None => values
                .items
                .push((key.0.into(), with_unit(&computed(nsm * importer.wtmass), importer.unit(Q::MassPerLength)))),
        }
    }
    axes_of_mass(importer, &mut values, given, rho.unwrap_or(0.0), is_beam);
    if !importer.coupled {
        values.items.push(("lumping".into(), "1".into()));
    } else if !is_beam {
        importer.report.approximate("coupled masses (PARAM COUPMASS) are those of retune's consistent mass");
    }
    Ok(values)
}

/// Where tension and mass lie, and the inertia about the axis: CBEAM turns ρ (I1 + I2), CBAR nothing.
fn axes_of_mass(importer: &Importer<'_>, values: &mut Values, given: &Given, rho: f64, is_beam: bool) {
    let [area, i1, i2, _, _, nsm] = given.numbers;
    let [ny, nz] = given.neutral;
    let (own, beside) = (rho * area, nsm);
    let mass = own + beside;
    for (key, v) in [("neutral_axis_y", ny), ("neutral_axis_z", nz)] {
        if v != 0.0 {
            values.items.push((key.into(), importer.length(v)));
        }
    }
    let centre: [f64; 2] =
        std::array::from_fn(
            |i| if mass > 0.0 { (own * given.neutral[i] + beside * given.nsm_at[i]) / mass } else { 0.0 },
        );
    for (key, v) in [("mass_offset_y", centre[0]), ("mass_offset_z", centre[1])] {
        if v != 0.0 {
            values.items.push((key.into(), importer.length(v)));
        }
    }
    // About the common centre of both masses.
    let apart = |at: [f64; 2], i: usize| (at[i] - centre[i]).powi(2);
    let about = |i: usize| own * apart(given.neutral, i) + beside * apart(given.nsm_at, i);
    let spread = about(0) + about(1) + if is_beam { given.nsi } else { 0.0 };
    let section = if is_beam { rho * (i1 + i2) } else { 0.0 };
    let unit = importer.unit(Q::InertiaPerLength);
    let inertia = |v: f64| with_unit(&computed(v * importer.wtmass), unit);
    // With a density the twist inertia is ρ (Iy + Iz) unless it is stated.
    let is_default = rho > 0.0 && is_beam && spread == 0.0 && i1 > 0.0 && i2 > 0.0;
    if !is_default && (rho > 0.0 || section + spread > 0.0) {
        values.items.push(("polar_inertia_per_length".into(), inertia(section + spread)));
    }
    for (key, v) in [("rotary_inertia_y", about(1)), ("rotary_inertia_z", about(0))] {
        if v > 0.0 {
            values.items.push((key.into(), inertia(v)));
        }
    }
}

/// The section of a rod or a tube.
pub(super) fn rod<'a>(importer: &mut Importer<'a>, property: &Card<'a>) -> Result<String, DeckError> {
    importer.section(property, "rod", |importer| {
        if property.name() == "PROD" {
            return rod_values(importer, property, [3, 4, 5, 7]);
        }
        let (outer, wall) = (property.real(4, "OD")?, property.real_or(5, "T", 0.0)?);
        let wall = if wall == 0.0 { 0.5 * outer } else { wall };
        if !(outer > 0.0 && wall > 0.0 && wall <= 0.5 * outer) {
            return Err(property.error(Some((5, "T")), "the wall must be at most half of the diameter"));
        }
        if property.optional_real(7, "OD2")?.is_some_and(|second| second != outer) {
            importer.report.approximate("tapered PTUBE have the section of their first end");
        }
        let inner = outer - 2.0 * wall;
        let area = PI / 4.0 * (outer * outer - inner * inner);
        let j = PI / 32.0 * (outer.powi(4) - inner.powi(4));
        plain(importer, property, 3, [area, j, property.real_or(6, "NSM", 0.0)?], None)
    })
}

/// A rod by its material, A, J and NSM.
///
/// * `[mid, a, j, nsm]` - fields of these
pub(super) fn rod_values(
    importer: &mut Importer<'_>,
    card: &Card<'_>,
    [mid, a, j, nsm]: [usize; 4],
) -> Result<Values, DeckError> {
    let numbers = [card.real_or(a, "A", 0.0)?, card.real_or(j, "J", 0.0)?, card.real_or(nsm, "NSM", 0.0)?];
    plain(importer, card, mid, numbers, Some([a, j, nsm]))
}

fn plain(
    importer: &mut Importer<'_>,
    card: &Card<'_>,
    mid: usize,
    [area, j, nsm]: [f64; 3],
    fields: Option<[usize; 3]>,
) -> Result<Values, DeckError> {
    for (k, (value, name)) in [(area, "A"), (j, "J"), (nsm, "NSM")].into_iter().enumerate() {
        if value < 0.0 {
            return Err(card.error(fields.map(|f| (f[k], name)), "it must not be negative"));
        }
    }
    let material = importer.material(card, mid, &["MAT1"])?;
    let mut values = Values::default();
    let (has_e, has_g) = for_members(importer, &material, &mut values)?;
    let mut put =
        |importer: &Importer<'_>, k: usize, key: &str, name: &'static str, value: f64, of: (Q, f64)| match fields {
            Some(f) => importer.put(&mut values, (key, key), (card, f[k], name), value, of),
            None => values.items.push((key.into(), with_unit(&computed(value * of.1), importer.unit(of.0)))),
        };
    if area > 0.0 {
        put(importer, 0, "A", "A", area, (Q::Area, 1.0));
    }
    if j > 0.0 && has_g {
        put(importer, 1, "J", "J", j, (Q::SecondMoment, 1.0));
    }
    if nsm > 0.0 {
        put(importer, 2, "added_mass_per_length", "NSM", nsm, (Q::MassPerLength, importer.wtmass));
    }
    if area == 0.0 || !has_e {
        values.items.push(("EA".into(), "0 N".into()));
    }
    if j == 0.0 || !has_g {
        values.items.push(("GJ".into(), "0 N m2".into()));
    }
    values.items.push(("EIy".into(), "0 N m2".into()));
    values.items.push(("EIz".into(), "0 N m2".into()));
    if area > 0.0 && density(importer, &material, &mut values)?.is_some() {
        values.items.push(("polar_inertia_per_length".into(), "0 kg m".into()));
    }
    values.items.push(("lumping".into(), "1".into()));
    if importer.coupled {
        // Coupled mass of a rod: m L/12 [5 1; 1 5] along it, lumped across.
        values.items.push(("lumping_along".into(), "0.5".into()));
    }
    Ok(values)
}
