//! Cross-sections of beams by their sizes.

use super::Named;
use crate::units::Scalar;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A cross-section, exactly one; y is its width direction, z its height direction, and the nodes are at its centroid.
///
/// The axes of an element with an `angle` are turned to the principal axes. J is that of Saint-Venant: a beam does not know warping.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShapeSpec {
    /// Solid rectangle: `width` along y, `height` along z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rectangle: Option<RectangleSpec>,
    /// Hollow rectangle of constant wall thickness: outer `width`, `height`, and `wall`.
    #[serde(default, rename = "box", skip_serializing_if = "Option::is_none")]
    pub hollow: Option<BoxSpec>,
    /// Solid circle: `diameter`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub circle: Option<CircleSpec>,
    /// Round tube: outer `diameter` and `wall`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tube: Option<TubeSpec>,
    /// I or H: the web along z, the flanges along y.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub i: Option<ISpec>,
    /// Channel (U, C): the web along z at the side of small y, the flanges along y. Its shear centre is behind the web.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub channel: Option<WebAndFlangeSpec>,
    /// Angle (L): a leg along y and a leg along z from the corner, which is at small y and z. The element's axes become the principal axes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub angle: Option<AngleSpec>,
    /// Tee (T): the web along z, the flange along y at the end of large z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tee: Option<WebAndFlangeSpec>,
    /// Plies, of a shell, or of a beam that is a flat strip in the x-y plane; the material is that of the plies, so that the section has no
    /// `E`, `G`, `thickness` and `density` beside it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub laminate: Option<LaminateSpec>,
}

/// Sizes of a solid rectangle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RectangleSpec {
    /// Size along the element's y axis.
    pub width: Scalar,
    /// Size along the element's z axis.
    pub height: Scalar,
}

/// Sizes of a hollow rectangle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoxSpec {
    /// Outer size along the element's y axis.
    pub width: Scalar,
    /// Outer size along the element's z axis.
    pub height: Scalar,
    /// Wall thickness.
    pub wall: Scalar,
}

/// Size of a solid circle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CircleSpec {
    /// Diameter.
    pub diameter: Scalar,
}

/// Sizes of a round tube.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TubeSpec {
    /// Outer diameter.
    pub diameter: Scalar,
    /// Wall thickness.
    pub wall: Scalar,
}

/// Sizes of an I or H.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ISpec {
    /// Size along the element's z axis, flanges included.
    pub height: Scalar,
    /// Width of the flanges along the element's y axis; of the one at large z where they differ.
    pub width: Scalar,
    /// Thickness of the web.
    pub web: Scalar,
    /// Thickness of the flanges; of the one at large z where they differ.
    pub flange: Scalar,
    /// Width of the flange at small z; that of the other when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bottom_width: Option<Scalar>,
    /// Thickness of the flange at small z; that of the other when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bottom_flange: Option<Scalar>,
    /// Radius between web and flanges; 0 when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fillet: Option<Scalar>,
}

/// Sizes of a channel or of a tee.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WebAndFlangeSpec {
    /// Size along the element's z axis, flanges included.
    pub height: Scalar,
    /// Size along the element's y axis: of the flanges of a channel with its web, of the flange of a tee.
    pub width: Scalar,
    /// Thickness of the web.
    pub web: Scalar,
    /// Thickness of each flange.
    pub flange: Scalar,
    /// Radius between web and flanges; 0 when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fillet: Option<Scalar>,
}

/// Sizes of an angle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AngleSpec {
    /// Size along y: of one leg, from the outside of the other.
    pub width: Scalar,
    /// Size along z: of the other leg.
    pub height: Scalar,
    /// Thickness of both.
    pub thickness: Scalar,
    /// Radius between the legs; 0 when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fillet: Option<Scalar>,
}

/// Plies on each other. Of a shell every number of them may be a parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LaminateSpec {
    /// Of a beam: size along the element's y axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub width: Option<Scalar>,
    /// Materials of the plies by name.
    pub materials: Named<PlyMaterialSpec>,
    /// The plies from small z to large z; of a shell z is its normal.
    pub plies: Vec<PlySpec>,
    /// Whether `plies` are the lower half only and lie once more above, in reverse order; no when absent.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub symmetric: bool,
}

/// A material of plies: isotropic by `E` and `nu`, or with fibres, in the axes of the ply: 1 along the fibres, 2 across them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlyMaterialSpec {
    /// Young's modulus of an isotropic material.
    #[serde(rename = "E", default, skip_serializing_if = "Option::is_none")]
    pub e: Option<Scalar>,
    /// Poisson's ratio of an isotropic material.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nu: Option<Scalar>,
    /// Young's modulus along the fibres.
    #[serde(rename = "E1", default, skip_serializing_if = "Option::is_none")]
    pub e1: Option<Scalar>,
    /// Young's modulus across the fibres.
    #[serde(rename = "E2", default, skip_serializing_if = "Option::is_none")]
    pub e2: Option<Scalar>,
    /// Shear modulus in the plane of the ply.
    #[serde(rename = "G12", default, skip_serializing_if = "Option::is_none")]
    pub g12: Option<Scalar>,
    /// Transverse shear modulus along the fibres, of a shell; G12 when absent.
    #[serde(rename = "G13", default, skip_serializing_if = "Option::is_none")]
    pub g13: Option<Scalar>,
    /// Transverse shear modulus across the fibres, of a shell; G12 when absent.
    #[serde(rename = "G23", default, skip_serializing_if = "Option::is_none")]
    pub g23: Option<Scalar>,
    /// Contraction across the fibres over extension along them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nu12: Option<Scalar>,
    /// Density.
    pub density: Scalar,
}

/// A ply.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlySpec {
    /// From the element's x axis to the fibres, towards its y axis: `45 deg`. Of a shell from the direction in which its `angle` is zero.
    pub angle: Scalar,
    /// Thickness.
    pub thickness: Scalar,
    /// Name of its material; may be left out where there is only one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
}
