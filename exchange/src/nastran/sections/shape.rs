//! Shapes of PBARL and PBEAML, by closed forms.
//!
//! Source: W. C. Young, R. G. Budynas, Roark's Formulas for Stress and Strain, 2002, tables A.1 and 10.1; S. P. Timoshenko, J. N. Goodier,
//! Theory of Elasticity, 1970, article 109, for torsion of a rectangle. Shear factors as in the tables of the solver's manual.

use crate::shapes::{centroid, composed, product, rectangle_j};
use crate::walls::walls;
use retune::deck::{Card, DeckError};
use std::f64::consts::PI;

/// Properties of a shape.
pub(super) struct Shape {
    pub area: f64,
    /// About z: bending in the first plane, x-y.
    pub i1: f64,
    pub i2: f64,
    pub i12: f64,
    pub j: f64,
    pub shear: [f64; 2],
    /// Centroid from the shear centre, (y, z).
    pub neutral: [f64; 2],
    pub nsm: f64,
    pub nsm_field: Option<(usize, &'static str)>,
    pub is_tapered: bool,
}

/// A way along the middle lines of walls: (z, y, thickness of the wall that leads there), zero for a way back.
type Way = Vec<[f64; 3]>;

pub(super) fn read(card: &Card<'_>) -> Result<Shape, DeckError> {
    let kind = card.text(5).to_uppercase();
    let count = match kind.as_str() {
        "ROD" => 1,
        "BAR" | "TUBE" | "TUBE2" => 2,
        "HEXA" => 3,
        "BOX" | "H" | "T" | "T1" | "T2" | "CHAN" | "CHAN1" | "CHAN2" | "I1" | "CROSS" | "HAT" | "Z" => 4,
        "L" if card.name() == "PBEAML" => 4,
        "I" | "BOX1" => 6,
        _ => {
            let shown: String = kind.chars().filter(|c| !c.is_control()).take(16).collect();
            let text = format!(
                "the shape `{shown}` is not read; known are ROD, TUBE, TUBE2, BAR, BOX, BOX1, I, I1, H, T, T1, T2, CHAN, CHAN1, CHAN2, CROSS, HAT, HEXA, Z and, of PBEAML, L; give a PBAR or PBEAM with A, I1, I2, J"
            );
            return Err(card.error(Some((5, "TYPE")), text));
        }
    };
    let mut d = [0.0; 6];
    for (i, slot) in d.iter_mut().enumerate().take(count) {
        *slot = card.real(10 + i, "DIM")?;
        if *slot <= 0.0 && !(kind == "TUBE" && i == 1 && *slot == 0.0) {
            return Err(card.error(Some((10 + i, "DIM")), "a dimension must be above zero"));
        }
    }
    let wrong = |n: usize, text: &str| Err(card.error(Some((9 + n, "DIM")), text));
    let bar = 5.0 / 6.0;
    // Of shapes whose centroid is not their shear centre, or whose axes are not principal.
    let (mut solid, mut way): (Vec<[f64; 4]>, Way) = (Vec::new(), Way::new());
    let ([area, i1, i2], j, shear) = match kind.as_str() {
        "ROD" => {
            let r4 = d[0].powi(4);
            ([PI * d[0] * d[0], PI / 4.0 * r4, PI / 4.0 * r4], PI / 2.0 * r4, [0.9, 0.9])
        }
        "TUBE" => {
            if d[1] >= d[0] {
                return wrong(2, "the inner radius must be below the outer one");
            }
            let i = PI / 4.0 * (d[0].powi(4) - d[1].powi(4));
            ([PI * (d[0] * d[0] - d[1] * d[1]), i, i], 2.0 * i, [0.5, 0.5])
        }
        // Outer radius and wall.
        "TUBE2" => {
            let inner = d[0] - d[1];
            if inner < 0.0 {
                return wrong(2, "the wall must not be thicker than the radius");
            }
            let i = PI / 4.0 * (d[0].powi(4) - inner.powi(4));
            ([PI * (d[0] * d[0] - inner * inner), i, i], 2.0 * i, [0.5, 0.5])
        }
        "BAR" => (composed(&[[d[0], d[1], 0.0, 0.0]]), rectangle_j(d[0], d[1]), [bar, bar]),
        "BOX" => {
            let [w, h, t1, t2, ..] = d;
            let (wi, hi) = (w - 2.0 * t2, h - 2.0 * t1);
            if wi <= 0.0 || hi <= 0.0 {
                return wrong(3, "the walls leave no hole");
            }
            let (wm, hm) = (w - t2, h - t1);
            let j = 2.0 * t1 * t2 * (wm * hm).powi(2) / (w * t2 + h * t1 - t1 * t1 - t2 * t2);
            let shear = [hi * 2.0 * t2 / (w * h - wi * hi), wi * 2.0 * t1 / (w * h - wi * hi)];
            (composed(&[[w, h, 0.0, 0.0], [-wi, hi, 0.0, 0.0]]), j, shear)
        }
        "I" => {
            // Height, width below, width above, web, flange below, flange above.
            let [h, w1, w2, tw, t1, t2] = d;
            let web = h - t1 - t2;
            if web <= 0.0 {
                return wrong(1, "the flanges leave no web");
            }
            let parts = [[w1, t1, 0.5 * t1, 0.0], [tw, web, t1 + 0.5 * web, 0.0], [w2, t2, h - 0.5 * t2, 0.0]];
            let middle = h - 0.5 * (t1 + t2);
            let area = composed(&parts)[0];
            let j = (w1 * t1.powi(3) + w2 * t2.powi(3) + middle * tw.powi(3)) / 3.0;
            if w1 != w2 || t1 != t2 {
                let (below, above) = (0.5 * t1, h - 0.5 * t2);
                solid = parts.to_vec();
                way = vec![
                    [-0.5 * w1, below, 0.0],
                    [0.5 * w1, below, t1],
                    [0.0, below, 0.0],
                    [0.0, above, tw],
                    [-0.5 * w2, above, t2],
                    [0.5 * w2, above, 0.0],
                    [0.0, above, t2],
                ];
            }
            (composed(&parts), j, [tw * web / area, (w1 * t1 + w2 * t2) * bar / area])
        }
        "I1" => {
            // Flange beside the web, web, height of the web, height in all.
            let [f, tw, web, h, ..] = d;
            if h <= web {
                return wrong(4, "the height in all must be above that of the web");
            }
            let t = 0.5 * (h - web);
            let w = f + tw;
            let parts = [[w, t, -0.5 * (web + t), 0.0], [tw, web, 0.0, 0.0], [w, t, 0.5 * (web + t), 0.0]];
            let area = composed(&parts)[0];
            let j = (2.0 * w * t.powi(3) + (h - t) * tw.powi(3)) / 3.0;
            (composed(&parts), j, [tw * web / area, 2.0 * w * t * bar / area])
        }
        "H" => {
            // Width between the flanges, both flanges, height, thickness of the bridge.
            let [b, f, h, t, ..] = d;
            let half = 0.5 * f;
            let side = 0.5 * (b + half);
            let parts = [[half, h, 0.0, -side], [b, t, 0.0, 0.0], [half, h, 0.0, side]];
            let area = composed(&parts)[0];
            let j = (2.0 * h * half.powi(3) + b * t.powi(3)) / 3.0;
            (composed(&parts), j, [f * h * bar / area, b * t / area])
        }
        "T" => {
            let [w, h, tf, tw, ..] = d;
            if h <= tf {
                return wrong(2, "the height must be above that of the flange");
            }
            let parts = [[w, tf, 0.0, 0.0], [tw, h - tf, -0.5 * h, 0.0]];
            solid = parts.to_vec();
            way = tee([0.5 * w, 0.0], [0.0, 0.5 * tf - h], [tf, tw]);
            let area = composed(&parts)[0];
            let j = (w * tf.powi(3) + (h - 0.5 * tf) * tw.powi(3)) / 3.0;
            (composed(&parts), j, [tw * (h - tf) / area, w * tf * bar / area])
        }
        "CHAN" => {
            let [w, h, tw, tf, ..] = d;
            if h <= 2.0 * tf || w <= tw {
                return wrong(3, "web and flanges do not fit into width and height");
            }
            let side = 0.5 * w - 0.5 * tw;
            let parts = [[w, tf, 0.5 * (h - tf), 0.0], [tw, h - 2.0 * tf, 0.0, -side], [w, tf, -0.5 * (h - tf), 0.0]];
            solid = parts.to_vec();
            let middle = 0.5 * (h - tf);
            way = bent([[0.5 * w, middle], [-side, middle], [-side, -middle], [0.5 * w, -middle]], [tf, tw, tf]);
            let area = composed(&parts)[0];
            let j = (2.0 * (w - 0.5 * tw) * tf.powi(3) + (h - tf) * tw.powi(3)) / 3.0;
            (composed(&parts), j, [tw * (h - 2.0 * tf) / area, 2.0 * tf * (w - tw) / area])
        }
        "BOX1" => {
            // Width, height, walls above, below, left, right.
            let [w, h, above, below, left, right] = d;
            let (wi, hi) = (w - left - right, h - above - below);
            if wi <= 0.0 || hi <= 0.0 {
                return wrong(3, "the walls leave no hole");
            }
            let hole = [-wi, hi, 0.5 * (below - above), 0.5 * (left - right)];
            let parts = [[w, h, 0.0, 0.0], hole];
            let (wm, hm) = (w - 0.5 * (left + right), h - 0.5 * (above + below));
            solid = parts.to_vec();
            let (l, r) = (0.5 * (left - w), 0.5 * (w - right));
            let (b, a) = (0.5 * (below - h), 0.5 * (h - above));
            way = bent([[l, b], [r, b], [r, a], [l, a], [l, b]], [below, right, above, left]);
            // Bredt: four times the enclosed area squared over the way round, each wall by its thickness.
            let j = 4.0 * (wm * hm).powi(2) / (wm / above + wm / below + hm / left + hm / right);
            let area = composed(&parts)[0];
            (composed(&parts), j, [hi * (left + right) / area, wi * (above + below) / area])
        }
        "T1" => {
            // Height of the flange, which stands, length of the web, which lies, thickness of flange and web.
            let [h, web, tf, tw, ..] = d;
            let parts = [[tf, h, 0.0, 0.0], [web, tw, 0.0, 0.5 * (tf + web)]];
            solid = parts.to_vec();
            way = tee([0.0, 0.5 * h], [web + 0.5 * tf, 0.0], [tf, tw]);
            let area = composed(&parts)[0];
            let j = (h * tf.powi(3) + web * tw.powi(3)) / 3.0;
            (composed(&parts), j, [h * tf * bar / area, web * tw / area])
        }
        "T2" => {
            // Width, height, flange below, web.
            let [w, h, tf, tw, ..] = d;
            if h <= tf {
                return wrong(2, "the height must be above that of the flange");
            }
            let parts = [[w, tf, 0.0, 0.0], [tw, h - tf, 0.5 * h, 0.0]];
            solid = parts.to_vec();
            way = tee([0.5 * w, 0.0], [0.0, h - 0.5 * tf], [tf, tw]);
            let area = composed(&parts)[0];
            let j = (w * tf.powi(3) + (h - 0.5 * tf) * tw.powi(3)) / 3.0;
            (composed(&parts), j, [tw * (h - tf) / area, w * tf * bar / area])
        }
        "CHAN1" => {
            // Flange beside the web, web, height of the web, height in all.
            let [f, tw, web, h, ..] = d;
            if h <= web {
                return wrong(4, "the height in all must be above that of the web");
            }
            let (t, w) = (0.5 * (h - web), f + tw);
            let parts = [[w, t, -0.5 * (web + t), 0.0], [tw, web, 0.0, -0.5 * f], [w, t, 0.5 * (web + t), 0.0]];
            solid = parts.to_vec();
            let middle = 0.5 * (web + t);
            way = bent([[0.5 * w, middle], [-0.5 * f, middle], [-0.5 * f, -middle], [0.5 * w, -middle]], [t, tw, t]);
            let area = composed(&parts)[0];
            let j = (2.0 * (w - 0.5 * tw) * t.powi(3) + (h - t) * tw.powi(3)) / 3.0;
            (composed(&parts), j, [tw * web / area, 2.0 * t * f / area])
        }
        "CHAN2" => {
            // Thickness of the legs, of the web, which lies above, height, width.
            let [tl, tw, h, w, ..] = d;
            if h <= tw || w <= 2.0 * tl {
                return wrong(3, "legs and web do not fit into width and height");
            }
            let (leg, side) = (h - tw, 0.5 * (w - tl));
            let parts = [[w, tw, 0.0, 0.0], [tl, leg, -0.5 * h, -side], [tl, leg, -0.5 * h, side]];
            solid = parts.to_vec();
            let foot = 0.5 * tw - h;
            way = bent([[-side, foot], [-side, 0.0], [side, 0.0], [side, foot]], [tl, tw, tl]);
            let area = composed(&parts)[0];
            let j = (2.0 * (h - 0.5 * tw) * tl.powi(3) + (w - tl) * tw.powi(3)) / 3.0;
            (composed(&parts), j, [2.0 * tl * leg / area, tw * (w - 2.0 * tl) / area])
        }
        "CROSS" => {
            // Both arms together, stem, its height, thickness of the arms.
            let [arms, tw, h, t, ..] = d;
            if h <= t {
                return wrong(3, "the height must be above the thickness of the arms");
            }
            let side = 0.5 * (tw + 0.5 * arms);
            let parts = [[tw, h, 0.0, 0.0], [0.5 * arms, t, 0.0, -side], [0.5 * arms, t, 0.0, side]];
            let area = composed(&parts)[0];
            let j = (h * tw.powi(3) + arms * t.powi(3)) / 3.0;
            (composed(&parts), j, [tw * h * bar / area, arms * t * bar / area])
        }
        "HAT" => {
            // Height, thickness, width above, width of each brim.
            let [h, t, top, brim, ..] = d;
            if h <= 2.0 * t || top <= 2.0 * t {
                return wrong(1, "the walls do not fit into height and width");
            }
            let side = 0.5 * (top - t);
            let foot = 0.5 * top + 0.5 * brim - 0.5 * t;
            let web = h - 2.0 * t;
            let parts = [
                [top, t, h - 0.5 * t, 0.0],
                [t, web, 0.5 * h, -side],
                [t, web, 0.5 * h, side],
                [brim + t, t, 0.5 * t, -foot],
                [brim + t, t, 0.5 * t, foot],
            ];
            solid = parts.to_vec();
            let (out, low, high) = (0.5 * top + brim, 0.5 * t, h - 0.5 * t);
            way = bent([[-out, low], [-side, low], [-side, high], [side, high], [side, low], [out, low]], [t; 5]);
            let area = composed(&parts)[0];
            let j = t.powi(3) * (top + 2.0 * web + 2.0 * (brim + t)) / 3.0;
            (composed(&parts), j, [2.0 * t * web / area, t * (top + 2.0 * brim) * bar / area])
        }
        "Z" => {
            // Flange beside the web, web, height of the web, height in all; the flange above lies on the side of -z.
            let [f, tw, web, h, ..] = d;
            if h <= web {
                return wrong(4, "the height in all must be above that of the web");
            }
            let (t, w) = (0.5 * (h - web), f + tw);
            let up = 0.5 * (web + t);
            let parts = [[w, t, up, -0.5 * f], [tw, web, 0.0, 0.0], [w, t, -up, 0.5 * f]];
            solid = parts.to_vec();
            let area = composed(&parts)[0];
            let j = (2.0 * w * t.powi(3) + (h - t) * tw.powi(3)) / 3.0;
            (composed(&parts), j, [tw * web / area, 2.0 * t * f / area])
        }
        "L" => {
            // Width, height, thickness of the leg that lies, of the one that stands.
            let [w, h, lying, standing, ..] = d;
            if h <= lying || w <= standing {
                return wrong(3, "the legs do not fit into width and height");
            }
            let parts = [[w, lying, 0.5 * lying, 0.5 * w], [standing, h - lying, 0.5 * (h + lying), 0.5 * standing]];
            solid = parts.to_vec();
            let corner = [0.5 * standing, 0.5 * lying];
            way = bent([[w, corner[1]], corner, [corner[0], h]], [lying, standing]);
            let area = composed(&parts)[0];
            let (b, up) = (w - 0.5 * standing, h - 0.5 * lying);
            let j = (b * lying.powi(3) + up * standing.powi(3)) / 3.0;
            (composed(&parts), j, [standing * (h - lying) / area, lying * (w - standing) / area])
        }
        _ => {
            // HEXA: of each slope the width, the width in all, the height: a rectangle and two triangles, apex at the side.
            let [slope, w, h, ..] = d;
            let inner = w - 2.0 * slope;
            if inner < 0.0 {
                return wrong(2, "the width in all must be at least that of both slopes");
            }
            let area = h * (inner + slope);
            let i1 = inner * h.powi(3) / 12.0 + slope * h.powi(3) / 24.0;
            let from = 0.5 * inner + slope / 3.0;
            let i2 = h * inner.powi(3) / 12.0 + h * slope * (slope * slope / 18.0 + from * from);
            // Saint-Venant's approximation of any solid section: A⁴ / (4 π² Ip).
            let j = area.powi(4) / (4.0 * PI * PI * (i1 + i2));
            ([area, i1, i2], j, [bar, bar])
        }
    };
    let nsm_at = 10 + count;
    // Behind the first end of a PBEAML stand stations.
    let second = (0..count).map(|i| card.text(nsm_at + 3 + i)).any(|t| !t.is_empty());
    let is_tapered = card.name() == "PBEAML" && second;
    let mut neutral = [0.0; 2];
    if !way.is_empty() {
        let points: Vec<[f64; 2]> = way.iter().map(|p| [p[0], p[1]]).collect();
        let thickness: Vec<f64> = way[1..].iter().map(|p| p[2]).collect();
        let thin = walls(&points, &thickness).map_err(|why| card.error(Some((10, "DIM")), why))?;
        let [y, z] = centroid(&solid);
        // Rounding is not a distance.
        let size = d.iter().fold(0.0_f64, |m, v| m.max(*v));
        neutral =
            [y - thin.shear_centre[1], z - thin.shear_centre[0]].map(|v| if v.abs() < 1e-12 * size { 0.0 } else { v });
    }
    let i12 = if matches!(kind.as_str(), "Z" | "L") { product(&solid) } else { 0.0 };
    let (i1, i2) = if kind == "BAR" { (d[0] * d[1].powi(3) / 12.0, d[1] * d[0].powi(3) / 12.0) } else { (i1, i2) };
    Ok(Shape {
        area,
        i1,
        i2,
        i12,
        j,
        shear,
        neutral,
        nsm: card.real_or(nsm_at, "NSM", 0.0)?,
        nsm_field: Some((nsm_at, "NSM")),
        is_tapered,
    })
}

/// A line of walls from corner to corner, each with its thickness.
fn bent<const N: usize, const M: usize>(points: [[f64; 2]; N], thickness: [f64; M]) -> Way {
    let of = std::iter::once(0.0).chain(thickness);
    points.into_iter().zip(of).map(|([z, y], t)| [z, y, t]).collect()
}

/// A flange about the origin, to both sides of it, and a stem from there.
fn tee([z, y]: [f64; 2], stem: [f64; 2], [flange, web]: [f64; 2]) -> Way {
    bent([[-z, -y], [0.0, 0.0], [z, y], [0.0, 0.0], stem], [flange, flange, 0.0, web])
}
