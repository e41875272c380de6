//! Model files of `models/` as text: structures on which benchmarks, examples and tests are run. Each says in its head what it is and whence
//! its numbers come.

/// A clamped steel strip: `models/cantilever.yaml`.
pub const CANTILEVER: &str = include_str!("../models/cantilever.yaml");
/// A free aluminium bar with a steel block at each end: `models/free_beam.yaml`.
pub const FREE_BEAM: &str = include_str!("../models/free_beam.yaml");
/// The Body Freedom Flutter aircraft, initial model: `models/bff.yaml`.
pub const FLYING_WING: &str = include_str!("../models/bff.yaml");
/// An aeroplane of the GARTEUR SM-AG19 kind: `models/garteur.yaml`.
pub const AEROPLANE: &str = include_str!("../models/garteur.yaml");
/// A steel portal frame in its plane: `models/frame.yaml`.
pub const FRAME: &str = include_str!("../models/frame.yaml");
/// A straight wing on plunge, roll and pitch springs: `models/wing_on_spring.yaml`.
pub const WING_ON_SPRINGS: &str = include_str!("../models/wing_on_spring.yaml");
