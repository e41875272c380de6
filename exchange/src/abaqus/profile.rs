//! Cross-sections of beams: the library of shapes, and constants given directly.
//!
//! Source of the shapes' sizes and of the shear factors: Abaqus Analysis User's Guide, beam cross-section library, and choosing a beam element
//! (transverse shear stiffness): k = 0.85 RECT, 0.89 CIRC, 0.53 PIPE and HEX, 0.44 BOX and I, 0.822 TRAPEZOID, 1 of L, ARBITRARY and where
//! constants are given.

use super::trapezoid;
use crate::shapes::{composed, rectangle_j};
use crate::walls;
use retune::deck::{DataLine, DeckError, Keyword};
use std::f64::consts::PI;

/// A section in its axes 1 (y of retune) and 2 (z).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Profile {
    pub area: f64,
    /// About axis 1, about axis 2, and the product.
    pub i11: f64,
    pub i22: f64,
    pub i12: f64,
    pub j: f64,
    /// Factor of the shear stiffness k G A.
    pub shear: f64,
    /// Centroid from the nodes.
    pub centroid: [f64; 2],
    /// Shear centre from the nodes, where it is not the centroid.
    pub shear_centre: Option<[f64; 2]>,
    /// Whether it is the same all round.
    pub is_round: bool,
    /// Whether it is a box of which one wall is next to nothing: it twists as an open section, and not about its centroid.
    pub is_nearly_open: bool,
}

/// Sizes on a data line, all above zero.
fn sizes<const N: usize>(line: &DataLine<'_>) -> Result<[f64; N], DeckError> {
    let mut out = [0.0; N];
    for (i, slot) in out.iter_mut().enumerate() {
        *slot = line.real(i, "size")?;
        if *slot <= 0.0 {
            return Err(line.error(Some((i, "size")), "it must be above zero"));
        }
    }
    Ok(out)
}

/// Number of data lines that the sizes of a shape take.
pub(super) fn n_lines(shape: &str, line: &DataLine<'_>) -> Result<usize, DeckError> {
    if shape == "ARBITRARY" { Ok(line.id(0, "number of segments")? as usize) } else { Ok(1) }
}

/// Segments of a section, at most.
const MOST_SEGMENTS: usize = 1000;

/// A wall of segments: their number, two points, a thickness; then a point and a thickness a line.
fn arbitrary(k: &Keyword<'_>, line: &DataLine<'_>) -> Result<walls::Walls, DeckError> {
    let n = n_lines("ARBITRARY", line)?;
    if n < 2 {
        let text = "one segment has no bending stiffness about itself; two at least are expected";
        return Err(line.error(Some((0, "number of segments")), text));
    }
    if n > MOST_SEGMENTS {
        return Err(line.error(Some((0, "number of segments")), format_args!("at most {MOST_SEGMENTS} are read")));
    }
    let mut points = vec![[line.real(1, "x1 of A")?, line.real(2, "x2 of A")?]];
    let mut thickness = Vec::new();
    for i in 0..n {
        let (line, first) =
            if i == 0 { (line.clone(), 3) } else { (k.needs_line(i, "x1, x2 and the thickness of a segment")?, 0) };
        points.push([line.real(first, "x1")?, line.real(first + 1, "x2")?]);
        let t = line.real(first + 2, "thickness")?;
        if t < 0.0 {
            return Err(line.error(Some((first + 2, "thickness")), "it must not be negative"));
        }
        thickness.push(t);
    }
    walls::walls(&points, &thickness).map_err(|why| line.error(None, why))
}

/// Reads the sizes of a shape of the library, or constants.
pub(super) fn read(k: &Keyword<'_>, shape: &str, line: &DataLine<'_>) -> Result<Profile, DeckError> {
    let plain = |area: f64, i11: f64, i22: f64, j: f64, shear: f64| Profile {
        area,
        i11,
        i22,
        i12: 0.0,
        j,
        shear,
        centroid: [0.0; 2],
        shear_centre: None,
        is_round: false,
        is_nearly_open: false,
    };
    let wrong = |i: usize, text: &str| Err(line.error(Some((i, "size")), text));
    Ok(match shape {
        "RECT" | "RECTANGULAR" => {
            let [a, b] = sizes(line)?;
            plain(a * b, a * b.powi(3) / 12.0, b * a.powi(3) / 12.0, rectangle_j(a, b), 0.85)
        }
        "CIRC" | "CIRCULAR" => {
            let [r] = sizes(line)?;
            let i = PI / 4.0 * r.powi(4);
            Profile { is_round: true, ..plain(PI * r * r, i, i, 2.0 * i, 0.89) }
        }
        "PIPE" | "THICKPIPE" => {
            let [r, t] = sizes(line)?;
            if t > r {
                return wrong(1, "the wall must not be thicker than the radius");
            }
            let inner = r - t;
            let i = PI / 4.0 * (r.powi(4) - inner.powi(4));
            Profile { is_round: true, ..plain(PI * (r * r - inner * inner), i, i, 2.0 * i, 0.53) }
        }
        "BOX" => {
            // Walls at +1, +2, -1, -2.
            let [a, b, t1, t2, t3, t4] = sizes(line)?;
            let (width, height) = (a - t1 - t3, b - t2 - t4);
            if width <= 0.0 || height <= 0.0 {
                return wrong(2, "the walls leave no hole");
            }
            // Parts of `composed` are (width along z, height along y, y, z) with bending about z first: here along 1, along 2, at 2, at 1.
            let parts = [[a, b, 0.0, 0.0], [-width, height, 0.5 * (t4 - t2), 0.5 * (t3 - t1)]];
            let [area, i11, i22] = composed(&parts);
            let (wm, hm) = (a - 0.5 * (t1 + t3), b - 0.5 * (t2 + t4));
            let j = 4.0 * (wm * hm).powi(2) / (hm / t1 + wm / t2 + hm / t3 + wm / t4);
            let hole = width * height;
            let at = |c: f64| -hole * c / area;
            let (c1, c2) = (at(0.5 * (t3 - t1)), at(0.5 * (t4 - t2)));
            // ∫ x1 x2 of the hole alone, about the common centroid.
            let i12 = -hole * 0.5 * (t3 - t1) * 0.5 * (t4 - t2) - area * c1 * c2;
            let walls = [t1, t2, t3, t4];
            let is_nearly_open = walls.iter().any(|t| walls.iter().any(|u| *t < 0.05 * u));
            Profile { i12, centroid: [c1, c2], is_nearly_open, ..plain(area, i11, i22, j, 0.44) }
        }
        "I" => {
            // From the nodes down to the lower edge, height, widths below and above, flanges below and above, web.
            let l = line.real(0, "l")?;
            let mut rest = [0.0; 6];
            for (i, slot) in rest.iter_mut().enumerate() {
                *slot = line.real(1 + i, "size")?;
                if *slot < 0.0 || (*slot == 0.0 && matches!(i, 0 | 5)) {
                    return wrong(1 + i, "it must be above zero");
                }
            }
            let [h, b1, b2, t1, t2, t3] = rest;
            let web = h - t1 - t2;
            if web <= 0.0 {
                return wrong(1, "the flanges leave no web");
            }
            let parts = [[b1, t1, 0.5 * t1, 0.0], [t3, web, t1 + 0.5 * web, 0.0], [b2, t2, h - 0.5 * t2, 0.0]];
            let [area, i11, i22] = composed(&parts);
            let centre = parts.iter().map(|p| p[0] * p[1] * p[2]).sum::<f64>() / area;
            let j = (b1 * t1.powi(3) + b2 * t2.powi(3) + (h - 0.5 * (t1 + t2)) * t3.powi(3)) / 3.0;
            // Each flange takes its share of a force along it by its stiffness.
            let share = [t1 * b1.powi(3), t2 * b2.powi(3)];
            let shear = (share[0] * 0.5 * t1 + share[1] * (h - 0.5 * t2)) / (share[0] + share[1]);
            let shear_centre = (share[0] + share[1] > 0.0).then_some([0.0, shear - l]);
            Profile { centroid: [0.0, centre - l], shear_centre, ..plain(area, i11, i22, j, 0.44) }
        }
        "L" => {
            // Legs along 1 and along 2, whose middle lines meet at the nodes.
            let [a, b, t1, t2] = sizes(line)?;
            if t1 >= b || t2 >= a {
                return wrong(2, "each leg must be longer than the other is thick");
            }
            let (rise, middle) = (b - t1, 0.5 * (a - t2));
            // Parts of `composed` are (width along z, height along y, y, z) with bending about z first: here along 1, along 2, at 2, at 1.
            let parts = [[a, t1, 0.0, middle], [t2, rise, 0.5 * b, 0.0]];
            let [area, i11, i22] = composed(&parts);
            let centre = |i: usize| parts.iter().map(|p| p[0] * p[1] * p[i]).sum::<f64>() / area;
            let centroid = [centre(3), centre(2)];
            let product = |p: &[f64; 4]| p[0] * p[1] * (p[3] - centroid[0]) * (p[2] - centroid[1]);
            let i12 = parts.iter().map(product).sum();
            let j = ((a - 0.5 * t2) * t1.powi(3) + (b - 0.5 * t1) * t2.powi(3)) / 3.0;
            Profile { i12, centroid, shear_centre: Some([0.0; 2]), ..plain(area, i11, i22, j, 1.0) }
        }
        "HEX" | "HEXAGONAL" => {
            // A tube of six equal sides, by the radius of its corners.
            let [r, t] = sizes(line)?;
            let root = 3.0_f64.sqrt();
            let inner = r - 2.0 * t / root;
            if inner <= 0.0 {
                return wrong(1, "the walls leave no hole");
            }
            let i = 5.0 * root / 16.0 * (r.powi(4) - inner.powi(4));
            let middle = r - t / root;
            // Bredt: 4 A²/Σ(l/t) of the middle line, A = 3√3/2 r².
            let j = 4.5 * middle.powi(3) * t;
            plain(1.5 * root * (r * r - inner * inner), i, i, j, 0.53)
        }
        "TRAPEZOID" | "TRAPEZOIDAL" => {
            // Width below, height, width above, from the lower edge up to the nodes.
            let [a, b, c] = sizes(line)?;
            let d = line.real_or(3, "d", 0.0)?;
            let [area, centre, i11, i22] = trapezoid::moments([a, b, c]);
            let j = trapezoid::torsion([a, b, c]);
            Profile { centroid: [0.0, centre - d], ..plain(area, i11, i22, j, 0.822) }
        }
        "ARBITRARY" => {
            let w = arbitrary(k, line)?;
            Profile {
                i12: w.i12,
                centroid: w.centroid,
                shear_centre: Some(w.shear_centre),
                ..plain(w.area, w.i11, w.i22, w.j, 1.0)
            }
        }
        "GENERAL" => {
            let [area, i11, i12, i22, j] = [0, 1, 2, 3, 4].map(|i| line.real_or(i, "constant", 0.0));
            let (area, i11, i12, i22, j) = (area?, i11?, i12?, i22?, j?);
            for (i, value) in [(0, area), (1, i11), (3, i22)] {
                if value <= 0.0 {
                    return Err(line.error(Some((i, "constant")), "it must be above zero"));
                }
            }
            if j < 0.0 {
                return Err(line.error(Some((4, "J")), "it must not be negative"));
            }
            if i12 * i12 >= i11 * i22 {
                return Err(line.error(Some((2, "I12")), "I12 squared must be below I11 times I22"));
            }
            if line.real_or(5, "sectorial moment", 0.0)? != 0.0 || line.real_or(6, "warping constant", 0.0)? != 0.0 {
                return Err(line.error(Some((5, "sectorial moment")), "beams that warp are not read"));
            }
            Profile { i12, ..plain(area, i11, i22, j, 1.0) }
        }
        other => {
            return Err(k.error(format_args!(
                "the shape `{other}` is not read; known are RECT, CIRC, PIPE, BOX, I, L, HEX, TRAPEZOID, ARBITRARY, GENERAL; give a BEAM GENERAL SECTION with A, I11, I12, I22, J"
            )));
        }
    })
}

impl Profile {
    /// From axis 1 to the first principal axis, rad.
    pub(super) fn turn(&self) -> f64 {
        if self.i12 == 0.0 { 0.0 } else { 0.5 * (2.0 * self.i12).atan2(self.i22 - self.i11) }
    }

    /// In its principal axes.
    pub(super) fn principal(&self) -> Profile {
        let angle = self.turn();
        if angle == 0.0 {
            return *self;
        }
        let (mean, half) = (0.5 * (self.i11 + self.i22), (0.5 * (self.i22 - self.i11)).hypot(self.i12));
        let (sin, cos) = angle.sin_cos();
        let [a, b] = self.centroid;
        Profile {
            i22: mean + half,
            i11: mean - half,
            i12: 0.0,
            centroid: [a * cos + b * sin, b * cos - a * sin],
            ..*self
        }
    }
}
