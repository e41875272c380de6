//! Springs, bushings and their properties.

use super::importer::{Grid, Importer, Values};
use super::scalars::End;
use super::{CardRule, left_out, read, refused, used};
use crate::system::Quantity as Q;
use crate::text::{exact, with_unit};
use crate::writer::Block;
use retune::deck::{Card, DeckError};
use retune::element::Dof;
use retune::linalg::vector3::{cross, dot, minus, plus, unit};
use retune::model::GLOBAL;

pub(super) const CARDS: &[CardRule] = &[
    read("CELAS1", "springs", celas).up_to(7),
    read("CELAS2", "springs", celas).up_to(9),
    read("CELAS3", "springs", celas).up_to(5),
    read("CELAS4", "springs", celas).up_to(5),
    read("CBUSH", "bushings", bush),
    used("PELAS", "springs"),
    used("PBUSH", "bushings"),
    read("CBUSH1D", "springs", bush_1d),
    refused("CBUSH2D", "bushings of rotors are not read; give a CBUSH"),
    refused("CFAST", "fasteners are not read; give a CBUSH between the sheets"),
    refused("CWELD", "welds are not read; give a CBUSH between the sheets"),
    refused("PFAST", "fasteners are not read; give a CBUSH between the sheets"),
    refused("PWELD", "welds are not read; give a CBUSH between the sheets"),
    refused("CGAP", "contact is not linear; give a CELAS2 for a gap that is closed"),
    left_out("PBUSHT", "frequency or load dependence"),
    left_out("PELAST", "frequency or load dependence"),
    used("PBUSH1D", "springs"),
    left_out("PGAP", "no element has it"),
    left_out("CDAMP1", "viscous damping"),
    left_out("CDAMP2", "viscous damping"),
    left_out("CDAMP3", "viscous damping"),
    left_out("CDAMP4", "viscous damping"),
    left_out("CDAMP5", "viscous damping"),
    left_out("CVISC", "viscous damping"),
    left_out("PDAMP", "viscous damping"),
    left_out("PDAMP5", "viscous damping"),
    left_out("PDAMPT", "viscous damping"),
    left_out("PVISC", "viscous damping"),
];

/// Quantities of stiffness and damping of a dof.
fn quantities(dof: Dof) -> [Q; 2] {
    if dof.is_rotation() { [Q::RotationalStiffness, Q::RotationalDamping] } else { [Q::Stiffness, Q::Damping] }
}

/// Fields of the two ends of a scalar element, with those of their components.
pub(super) fn ends(card: &Card<'_>) -> [(usize, Option<usize>); 2] {
    let is_scalar = matches!(card.name(), "CELAS3" | "CELAS4" | "CMASS3" | "CMASS4");
    if is_scalar { [(4, None), (5, None)] } else { [(4, Some(5)), (6, Some(7))] }
}

fn celas<'a>(importer: &mut Importer<'a>, card: &Card<'a>) -> Result<(), DeckError> {
    // CELAS1 and CELAS3 refer to a property, CELAS2 and CELAS4 have their stiffness themselves; 3 and 4 join scalar points.
    let (property, source, field) = if matches!(card.name(), "CELAS1" | "CELAS3") {
        let property = importer.property(card, 3, &["PELAS"])?;
        let pid = card.optional_id(3, "PID")?.map_or_else(|| card.id_at(2, "EID"), Ok)?;
        let first = if property.optional_id(2, "PID")? == Some(pid) { 2 } else { 6 };
        (Some(property.clone()), property, first + 1)
    } else {
        (None, card.clone(), 3)
    };
    let places = ends(card);
    let k = source.real(field, "K")?;
    if k < 0.0 {
        return Err(source.error(Some((field, "K")), "a negative stiffness is not read"));
    }
    let (first, second) = (importer.end(card, places[0], "G1")?, importer.end(card, places[1], "G2")?);
    let (one, other) = match (first, second) {
        (Some(a), b) => (a, b),
        (None, Some(b)) => (b, None),
        (None, None) => return Err(card.error(Some((4, "G1")), "a spring needs a grid or a scalar point")),
    };
    let mut values = Values::default();
    let from = (&source, field, "K");
    let Some(second) = other else {
        let dof = Dof::ALL[one.component];
        values.items.push(("node".into(), one.node.clone()));
        let k =
            put_nested(importer, &mut values, (dof.name(), &format!("k_{dof}")), from, k, (quantities(dof)[0], 1.0));
        values.items.push(("k".into(), format!("{{{k}}}")));
        let frame = one.grid.and_then(|grid| frame_of_grid(importer, &one.node, &grid));
        values.items.extend(frame.map(|f| ("frame".to_string(), f)));
        return importer.element(Block::Springs, card, values, property.as_ref(), None).map(|_| ());
    };
    if is_rotation(&one) != is_rotation(&second) {
        importer
            .report
            .note("springs between a displacement and a rotation count radians as the deck's unit of length");
    }
    // k acts on a length: a torsion spring of k has factors of one unit of length.
    let k = put_nested(importer, &mut values, ("k", "k"), from, k, (Q::Stiffness, 1.0));
    between(importer, card, values, k, [&one, &second], property.as_ref())
}

fn is_rotation(end: &End) -> bool {
    end.component >= 3
}

/// A scalar element between two ends: δ between any two dofs, factors along global axes; those of rotations are lengths.
///
/// * `size` - its property, as it is written
pub(super) fn between<'a>(
    importer: &mut Importer<'a>,
    card: &Card<'a>,
    mut values: Values,
    size: String,
    ends: [&End; 2],
    property: Option<&Card<'a>>,
) -> Result<(), DeckError> {
    let length = importer.unit(Q::Length);
    let mut properties = vec![size];
    for (prefix, sign, end) in [("a", -1.0, ends[0]), ("b", 1.0, ends[1])] {
        for &(dof, factor) in &end.terms {
            let unit = if dof.is_rotation() { length } else { "" };
            properties.push(format!("{prefix}_{dof}: {}", with_unit(&exact(sign * factor), unit)));
        }
    }
    let head = [
        ("type".to_string(), "scalar_spring".to_string()),
        ("nodes".to_string(), format!("[{}, {}]", ends[0].node, ends[1].node)),
        ("properties".to_string(), format!("{{{}}}", properties.join(", "))),
    ];
    values.items.extend(head);
    importer.element(Block::Elements, card, values, property, None).map(|_| ())
}

/// CBUSH1D: a spring along the line between two grids.
fn bush_1d<'a>(importer: &mut Importer<'a>, card: &Card<'a>) -> Result<(), DeckError> {
    let property = importer.property(card, 3, &["PBUSH1D"])?;
    let refused = |field: usize, name: &'static str, text: &str| Err(card.error(Some((field, name)), text));
    if card.is_blank(5) || !card.is_blank(6) {
        return refused(6, "CID", "one-dimensional bushings are read between two grids that are apart; give a CBUSH");
    }
    if property.real_or(5, "M", 0.0)? != 0.0 {
        return Err(property.error(Some((5, "M")), "a mass of bushings is not read; give a CONM2 at each end"));
    }
    let k = property.real_or(3, "K", 0.0)?;
    if k <= 0.0 {
        return Err(property.error(Some((3, "K")), "a stiffness above zero is expected"));
    }
    let ((a, ga), (b, gb)) = (importer.grid(card, 4, "GA")?, importer.grid(card, 5, "GB")?);
    if unit(minus(gb.position, ga.position)).is_none() {
        return refused(5, "GB", "its grids are at one place, so it has no line; give a CBUSH with CID");
    }
    let mut values = Values::default();
    values.items.push(("nodes".into(), format!("[{a}, {b}]")));
    let k = put_nested(importer, &mut values, ("axial", "k"), (&property, 3, "K"), k, (Q::Stiffness, 1.0));
    values.items.push(("k".into(), format!("{{{k}}}")));
    importer.element(Block::Springs, card, values, Some(&property), None).map(|_| ())
}

/// Puts a field under a property whose entry stands inside a map; the entry's text.
pub(super) fn put_nested(
    importer: &Importer<'_>,
    values: &mut Values,
    key: (&str, &str),
    from: (&Card<'_>, usize, &'static str),
    value: f64,
    of: (Q, f64),
) -> String {
    importer.put(values, key, from, value, of);
    values.items.pop().map_or_else(String::new, |(k, v)| format!("{k}: {v}"))
}

/// The frame of the displacements of a grid; none where they are along global axes.
pub(super) fn frame_of_grid(importer: &mut Importer<'_>, node: &str, grid: &Grid) -> Option<String> {
    let coord = *importer.coords.get(&grid.cd)?;
    if importer.is_global(grid) {
        return None;
    }
    let axes = importer.displacement_axes(grid);
    let is_rectangular = coord.axes_at(plus(grid.position, 1.0, axes[0])) == axes;
    if is_rectangular && let Some(frame) = importer.frame(grid.cd, &coord, grid.position) {
        return Some(frame);
    }
    let own = format!("axes_{node}");
    if !importer.turned.contains_key(&own) {
        importer.write_frame(&own, grid.position, axes);
    }
    Some(own)
}

fn bush<'a>(importer: &mut Importer<'a>, card: &Card<'a>) -> Result<(), DeckError> {
    let property = importer.property(card, 3, &["PBUSH"])?;
    let (first, ga) = importer.grid(card, 4, "GA")?;
    let second = if matches!(card.text(5), "" | "0") { None } else { Some(importer.grid(card, 5, "GB")?) };
    let mut values = Values::default();
    let mut arms = [[0.0; 3]; 2];
    match &second {
        Some((name, gb)) => {
            values.items.push(("nodes".into(), format!("[{first}, {name}]")));
            // S is where the spring lies between its grids; with OCID it is a point of its own.
            let s = card.real_or(10, "S", 0.5)?;
            let ocid = card.integer_or(11, "OCID", -1)?;
            if ocid >= 0 {
                let (_, coord) = importer.coord(card, 11, "OCID")?;
                let axes = coord.axes_at(ga.position);
                let offset = card.vector(12, "S1")?;
                arms[0] = (0..3).fold([0.0; 3], |sum, i| plus(sum, offset[i], axes[i]));
                arms[1] = minus(plus(ga.position, 1.0, arms[0]), gb.position);
            } else if s != 0.5 {
                if !(0.0..=1.0).contains(&s) {
                    return Err(card.error(Some((10, "S")), "a fraction from 0 to 1 is expected"));
                }
                values.items.push(("location".into(), exact(s)));
            }
        }
        None => values.items.push(("node".into(), first.clone())),
    }
    let mut stiffness = Vec::new();
    let mut damping = Vec::new();
    let mut at = 3;
    let mut has_k = false;
    while at <= property.len() {
        let word = property.text(at).to_uppercase();
        match word.as_str() {
            "K" | "B" => {
                has_k |= word == "K";
                for (i, dof) in Dof::ALL.into_iter().enumerate() {
                    let names = if word == "K" {
                        ["K1", "K2", "K3", "K4", "K5", "K6"]
                    } else {
                        ["B1", "B2", "B3", "B4", "B5", "B6"]
                    };
                    let (field, name) = (at + 1 + i, names[i]);
                    let Some(value) = property.optional_real(field, name)? else { continue };
                    if value < 0.0 {
                        return Err(property.error(Some((field, name)), "it must not be negative"));
                    }
                    if value == 0.0 && word == "B" {
                        continue;
                    }
                    let (prefix, q, list) = if word == "K" {
                        ("k", quantities(dof)[0], &mut stiffness)
                    } else {
                        ("c", quantities(dof)[1], &mut damping)
                    };
                    let key = (dof.name(), format!("{prefix}_{dof}"));
                    let text =
                        put_nested(importer, &mut values, (key.0, &key.1), (&property, field, name), value, (q, 1.0));
                    list.push(text);
                }
            }
            "GE" => importer.report.note("structural damping (GE) is left out: normal modes do not know it"),
            "RCV" | "T" | "" => {}
            "M" => {
                if property.optional_real(at + 1, "M")?.is_some_and(|m| m != 0.0) {
                    return Err(property.error(Some((at + 1, "M")), "a mass of a bushing is not read; give a CONM2"));
                }
            }
            _ => return Err(property.error(Some((at, "K")), "one of K, B, GE, RCV, M is expected")),
        }
        at += 8;
    }
    if stiffness.is_empty() && damping.is_empty() {
        let text = if has_k { "it has no stiffness" } else { "it has no line of K" };
        return Err(property.error(None, text));
    }
    if !stiffness.is_empty() {
        values.items.push(("k".into(), format!("{{{}}}", stiffness.join(", "))));
    }
    if !damping.is_empty() {
        values.items.push(("c".into(), format!("{{{}}}", damping.join(", "))));
    }
    values.items.extend(
        bush_frame(importer, card, &first, &ga, second.as_ref().map(|s| s.1))?.map(|f| ("frame".to_string(), f)),
    );
    if arms != [[0.0; 3]; 2] {
        let both = arms.map(|v| importer.lengths(v)).join(", ");
        values.items.push(("offsets".into(), format!("[{both}]")));
    }
    let block = if second.is_some() { Block::Bushings } else { Block::Springs };
    importer.element(block, card, values, Some(&property), None).map(|_| ())
}

/// Axes of a bushing: those of CID, or along its grids, or those of the displacements of its grid.
fn bush_frame(
    importer: &mut Importer<'_>,
    card: &Card<'_>,
    node: &str,
    ga: &Grid,
    gb: Option<Grid>,
) -> Result<Option<String>, DeckError> {
    if !card.is_blank(9) {
        let (id, coord) = importer.coord(card, 9, "CID")?;
        return Ok(importer.frame(id, &coord, ga.position));
    }
    let along = gb.and_then(|gb| unit(minus(gb.position, ga.position)));
    let third = card.text(6);
    let is_grid = !third.is_empty() && !third.contains('.') && card.is_blank(7) && card.is_blank(8);
    let toward = if is_grid {
        minus(importer.grid(card, 6, "G0")?.1.position, ga.position)
    } else {
        let v = card.vector(6, "X1")?;
        let axes = importer.displacement_axes(ga);
        (0..3).fold([0.0; 3], |sum, i| plus(sum, v[i], axes[i]))
    };
    let Some(x) = along else {
        if toward != [0.0; 3] {
            return Err(card.error(Some((9, "CID")), "grids at one place give no axis; name a coordinate system"));
        }
        return Ok(frame_of_grid(importer, node, ga));
    };
    let y = if toward == [0.0; 3] {
        // Without a direction only the axial spring and the twist may be there; any frame about the axis holds.
        let i = (0..3).min_by(|a, b| x[*a].abs().total_cmp(&x[*b].abs())).unwrap_or(0);
        GLOBAL[i]
    } else {
        toward
    };
    let y = plus(y, -dot(y, x), x);
    let y = unit(y).filter(|_| dot(y, y) > 1e-12 * dot(toward, toward).max(1e-300));
    let y = y.ok_or_else(|| card.error(Some((6, "X1")), "its direction is along the element itself"))?;
    let axes = [x, y, cross(x, y)];
    if axes == GLOBAL {
        return Ok(None);
    }
    let name = importer.names.unique(&format!("axes_cbush_{}", card.id_at(2, "EID")?));
    importer.write_frame(&name, ga.position, axes);
    Ok(Some(name))
}
