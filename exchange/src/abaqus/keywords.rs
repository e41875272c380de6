//! The catalogue of keywords: what each becomes, why it is left out, or why it is refused.

/// What is done with a keyword.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KeywordUse {
    /// It becomes part of the model: of which kind.
    Read(&'static str),
    /// It says nothing of small vibrations: what it is for.
    LeftOut(&'static str),
    /// The model cannot hold it: why.
    Refused(&'static str),
}

/// One line of the catalogue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct KeywordRule {
    /// Name without blanks: `SOLIDSECTION`.
    pub name: &'static str,
    /// Name as manuals write it.
    pub shown: &'static str,
    /// What is done with it.
    pub use_of: KeywordUse,
}

const fn read(name: &'static str, shown: &'static str, becomes: &'static str) -> KeywordRule {
    KeywordRule { name, shown, use_of: KeywordUse::Read(becomes) }
}

const fn left_out(name: &'static str, shown: &'static str, why: &'static str) -> KeywordRule {
    KeywordRule { name, shown, use_of: KeywordUse::LeftOut(why) }
}

const fn refused(name: &'static str, shown: &'static str, why: &'static str) -> KeywordRule {
    KeywordRule { name, shown, use_of: KeywordUse::Refused(why) }
}

const OUTPUT: &str = "output";
const LOADS: &str = "loads";
const SOLUTION: &str = "how the solver works";
const STATICS: &str = "other steps";
const NONLINEAR: &str = "nonlinear material";
const HEAT: &str = "heat";
const DAMPING: &str = "damping";
const CONTACT: &str = "contact, which is not linear";
const OPTIMISATION: &str = "optimisation by the solver";
const GENERATED: &str =
    "nodes and elements that the solver generates are not read; give the deck that the preprocessor writes in full";

/// The catalogue.
pub const KEYWORDS: &[KeywordRule] = &[
    read("HEADING", "HEADING", "title"),
    read("NODE", "NODE", "nodes"),
    read("ELEMENT", "ELEMENT", "elements"),
    read("NSET", "NSET", "sets"),
    read("ELSET", "ELSET", "groups"),
    read("SURFACE", "SURFACE", "sets"),
    read("PART", "PART", "instances"),
    read("ENDPART", "END PART", "instances"),
    read("ASSEMBLY", "ASSEMBLY", "instances"),
    read("ENDASSEMBLY", "END ASSEMBLY", "instances"),
    read("INSTANCE", "INSTANCE", "instances"),
    read("ENDINSTANCE", "END INSTANCE", "instances"),
    read("SYSTEM", "SYSTEM", "nodes"),
    read("TRANSFORM", "TRANSFORM", "axes"),
    read("ORIENTATION", "ORIENTATION", "axes"),
    read("MATERIAL", "MATERIAL", "materials"),
    read("ELASTIC", "ELASTIC", "materials"),
    read("DENSITY", "DENSITY", "materials"),
    read("SOLIDSECTION", "SOLID SECTION", "sections"),
    read("SHELLSECTION", "SHELL SECTION", "sections"),
    read("SHELLGENERALSECTION", "SHELL GENERAL SECTION", "sections"),
    read("BEAMSECTION", "BEAM SECTION", "sections"),
    read("BEAMGENERALSECTION", "BEAM GENERAL SECTION", "sections"),
    read("TRANSVERSESHEARSTIFFNESS", "TRANSVERSE SHEAR STIFFNESS", "sections"),
    read("TRANSVERSESHEAR", "TRANSVERSE SHEAR", "sections"),
    read("CENTROID", "CENTROID", "sections"),
    read("SHEARCENTER", "SHEAR CENTER", "sections"),
    read("MASS", "MASS", "masses"),
    read("ROTARYINERTIA", "ROTARY INERTIA", "masses"),
    read("SPRING", "SPRING", "springs"),
    read("CONNECTORSECTION", "CONNECTOR SECTION", "connectors"),
    read("CONNECTORBEHAVIOR", "CONNECTOR BEHAVIOR", "connectors"),
    read("CONNECTORELASTICITY", "CONNECTOR ELASTICITY", "connectors"),
    left_out("CONNECTORDAMPING", "CONNECTOR DAMPING", DAMPING),
    left_out("CONNECTORCONSTITUTIVEREFERENCE", "CONNECTOR CONSTITUTIVE REFERENCE", NONLINEAR),
    left_out("CONNECTORFRICTION", "CONNECTOR FRICTION", NONLINEAR),
    left_out("CONNECTORSTOP", "CONNECTOR STOP", CONTACT),
    left_out("CONNECTORLOAD", "CONNECTOR LOAD", LOADS),
    read("DASHPOT", "DASHPOT", "springs"),
    read("TIE", "TIE", "constraints"),
    read("COUPLING", "COUPLING", "links"),
    read("KINEMATIC", "KINEMATIC", "links"),
    read("DISTRIBUTING", "DISTRIBUTING", "links"),
    read("KINEMATICCOUPLING", "KINEMATIC COUPLING", "links"),
    read("DISTRIBUTINGCOUPLING", "DISTRIBUTING COUPLING", "links"),
    read("MPC", "MPC", "links"),
    read("RIGIDBODY", "RIGID BODY", "links"),
    read("EQUATION", "EQUATION", "constraints"),
    read("BOUNDARY", "BOUNDARY", "supports"),
    read("STEP", "STEP", "step"),
    read("ENDSTEP", "END STEP", "step"),
    read("FREQUENCY", "FREQUENCY", "step"),
    // What says nothing of small vibrations.
    left_out("PREPRINT", "PREPRINT", OUTPUT),
    left_out("RESTART", "RESTART", OUTPUT),
    left_out("OUTPUT", "OUTPUT", OUTPUT),
    left_out("NODEOUTPUT", "NODE OUTPUT", OUTPUT),
    left_out("ELEMENTOUTPUT", "ELEMENT OUTPUT", OUTPUT),
    left_out("CONTACTOUTPUT", "CONTACT OUTPUT", OUTPUT),
    left_out("ENERGYOUTPUT", "ENERGY OUTPUT", OUTPUT),
    left_out("MODALOUTPUT", "MODAL OUTPUT", OUTPUT),
    left_out("NODEPRINT", "NODE PRINT", OUTPUT),
    left_out("ELPRINT", "EL PRINT", OUTPUT),
    left_out("NODEFILE", "NODE FILE", OUTPUT),
    left_out("ELFILE", "EL FILE", OUTPUT),
    left_out("ELEMENTPRINT", "ELEMENT PRINT", OUTPUT),
    left_out("ELEMENTFILE", "ELEMENT FILE", OUTPUT),
    left_out("FACEPRINT", "FACE PRINT", OUTPUT),
    left_out("SECTIONPRINT", "SECTION PRINT", OUTPUT),
    left_out("SECTIONFILE", "SECTION FILE", OUTPUT),
    left_out("CONTACTPRINT", "CONTACT PRINT", OUTPUT),
    left_out("CONTACTFILE", "CONTACT FILE", OUTPUT),
    left_out("MODALPRINT", "MODAL PRINT", OUTPUT),
    left_out("MODALFILE", "MODAL FILE", OUTPUT),
    left_out("ENERGYPRINT", "ENERGY PRINT", OUTPUT),
    left_out("ENERGYFILE", "ENERGY FILE", OUTPUT),
    left_out("RADIATIONOUTPUT", "RADIATION OUTPUT", OUTPUT),
    left_out("INTEGRATEDOUTPUT", "INTEGRATED OUTPUT", OUTPUT),
    left_out("INTEGRATEDOUTPUTSECTION", "INTEGRATED OUTPUT SECTION", OUTPUT),
    left_out("FILEFORMAT", "FILE FORMAT", OUTPUT),
    left_out("PRINT", "PRINT", OUTPUT),
    left_out("MONITOR", "MONITOR", OUTPUT),
    left_out("FILTER", "FILTER", OUTPUT),
    left_out("TIMEPOINTS", "TIME POINTS", OUTPUT),
    left_out("SECTIONPOINTS", "SECTION POINTS", OUTPUT),
    left_out("ELEMENTMATRIXOUTPUT", "ELEMENT MATRIX OUTPUT", OUTPUT),
    left_out("MATRIXOUTPUT", "MATRIX OUTPUT", OUTPUT),
    left_out("PSDDEFINITION", "PSD-DEFINITION", LOADS),
    left_out("CLOAD", "CLOAD", LOADS),
    left_out("DLOAD", "DLOAD", LOADS),
    left_out("DSLOAD", "DSLOAD", LOADS),
    left_out("DSFLUX", "DSFLUX", LOADS),
    left_out("CFLUX", "CFLUX", LOADS),
    left_out("DFLUX", "DFLUX", LOADS),
    left_out("FILM", "FILM", LOADS),
    left_out("SFILM", "SFILM", LOADS),
    left_out("RADIATE", "RADIATE", LOADS),
    left_out("TEMPERATURE", "TEMPERATURE", LOADS),
    left_out("AMPLITUDE", "AMPLITUDE", LOADS),
    left_out("BASEMOTION", "BASE MOTION", LOADS),
    left_out("INERTIALOAD", "INERTIA LOAD", LOADS),
    left_out("FIELD", "FIELD", LOADS),
    left_out("LOADCASE", "LOAD CASE", LOADS),
    left_out("ENDLOADCASE", "END LOAD CASE", LOADS),
    left_out("PHYSICALCONSTANTS", "PHYSICAL CONSTANTS", SOLUTION),
    left_out("CONTROLS", "CONTROLS", SOLUTION),
    left_out("SOLVERCONTROLS", "SOLVER CONTROLS", SOLUTION),
    left_out("SECTIONCONTROLS", "SECTION CONTROLS", SOLUTION),
    left_out("HOURGLASSSTIFFNESS", "HOURGLASS STIFFNESS", SOLUTION),
    left_out("NORMAL", "NORMAL", SOLUTION),
    left_out("ALIAS", "ALIAS", SOLUTION),
    left_out("STATIC", "STATIC", STATICS),
    left_out("DYNAMIC", "DYNAMIC", STATICS),
    left_out("BUCKLE", "BUCKLE", STATICS),
    left_out("MODALDYNAMIC", "MODAL DYNAMIC", STATICS),
    left_out("STEADYSTATEDYNAMICS", "STEADY STATE DYNAMICS", STATICS),
    left_out("RESPONSESPECTRUM", "RESPONSE SPECTRUM", STATICS),
    left_out("RANDOMRESPONSE", "RANDOM RESPONSE", STATICS),
    left_out("COMPLEXFREQUENCY", "COMPLEX FREQUENCY", STATICS),
    left_out("SELECTEIGENMODES", "SELECT EIGENMODES", STATICS),
    left_out("SENSITIVITY", "SENSITIVITY", STATICS),
    left_out("GREEN", "GREEN", STATICS),
    left_out("VISCO", "VISCO", STATICS),
    left_out("COUPLEDTEMPERATURE-DISPLACEMENT", "COUPLED TEMPERATURE-DISPLACEMENT", STATICS),
    left_out("UNCOUPLEDTEMPERATURE-DISPLACEMENT", "UNCOUPLED TEMPERATURE-DISPLACEMENT", STATICS),
    left_out("HEATTRANSFER", "HEAT TRANSFER", HEAT),
    left_out("NOANALYSIS", "NO ANALYSIS", STATICS),
    left_out("INITIALCONDITIONS", "INITIAL CONDITIONS", "initial states"),
    left_out("DAMPING", "DAMPING", DAMPING),
    left_out("MODALDAMPING", "MODAL DAMPING", DAMPING),
    left_out("GLOBALDAMPING", "GLOBAL DAMPING", DAMPING),
    left_out("EXPANSION", "EXPANSION", HEAT),
    left_out("CONDUCTIVITY", "CONDUCTIVITY", HEAT),
    left_out("SPECIFICHEAT", "SPECIFIC HEAT", HEAT),
    left_out("LATENTHEAT", "LATENT HEAT", HEAT),
    left_out("INELASTICHEATFRACTION", "INELASTIC HEAT FRACTION", HEAT),
    left_out("PLASTIC", "PLASTIC", NONLINEAR),
    left_out("CYCLICHARDENING", "CYCLIC HARDENING", NONLINEAR),
    left_out("RATEDEPENDENT", "RATE DEPENDENT", NONLINEAR),
    left_out("CREEP", "CREEP", NONLINEAR),
    left_out("VISCOELASTIC", "VISCOELASTIC", NONLINEAR),
    left_out("POTENTIAL", "POTENTIAL", NONLINEAR),
    left_out("DAMAGEINITIATION", "DAMAGE INITIATION", NONLINEAR),
    left_out("DAMAGEEVOLUTION", "DAMAGE EVOLUTION", NONLINEAR),
    left_out("FAILSTRESS", "FAIL STRESS", NONLINEAR),
    left_out("FAILSTRAIN", "FAIL STRAIN", NONLINEAR),
    left_out("CONCRETE", "CONCRETE", NONLINEAR),
    left_out("FAILURERATIOS", "FAILURE RATIOS", NONLINEAR),
    left_out("TENSIONSTIFFENING", "TENSION STIFFENING", NONLINEAR),
    left_out("SHEARRETENTION", "SHEAR RETENTION", NONLINEAR),
    left_out("BRITTLECRACKING", "BRITTLE CRACKING", NONLINEAR),
    left_out("BRITTLESHEAR", "BRITTLE SHEAR", NONLINEAR),
    left_out("BRITTLEFAILURE", "BRITTLE FAILURE", NONLINEAR),
    left_out("DRUCKERPRAGER", "DRUCKER PRAGER", NONLINEAR),
    left_out("DRUCKERPRAGERHARDENING", "DRUCKER PRAGER HARDENING", NONLINEAR),
    left_out("CAPPLASTICITY", "CAP PLASTICITY", NONLINEAR),
    left_out("CAPHARDENING", "CAP HARDENING", NONLINEAR),
    left_out("ANNEALTEMPERATURE", "ANNEAL TEMPERATURE", NONLINEAR),
    left_out("TENSILEFAILURE", "TENSILE FAILURE", NONLINEAR),
    left_out("CONCRETEDAMAGEDPLASTICITY", "CONCRETE DAMAGED PLASTICITY", NONLINEAR),
    left_out("CONCRETECOMPRESSIONHARDENING", "CONCRETE COMPRESSION HARDENING", NONLINEAR),
    left_out("CONCRETETENSIONSTIFFENING", "CONCRETE TENSION STIFFENING", NONLINEAR),
    left_out("CONCRETECOMPRESSIONDAMAGE", "CONCRETE COMPRESSION DAMAGE", NONLINEAR),
    left_out("CONCRETETENSIONDAMAGE", "CONCRETE TENSION DAMAGE", NONLINEAR),
    left_out("SURFACEINTERACTION", "SURFACE INTERACTION", CONTACT),
    left_out("SURFACEBEHAVIOR", "SURFACE BEHAVIOR", CONTACT),
    left_out("FRICTION", "FRICTION", CONTACT),
    left_out("CONTACTDAMPING", "CONTACT DAMPING", CONTACT),
    left_out("CONTACTCONTROLS", "CONTACT CONTROLS", CONTACT),
    left_out("GAPCONDUCTANCE", "GAP CONDUCTANCE", HEAT),
    left_out("FLUIDCONSTANTS", "FLUID CONSTANTS", HEAT),
    left_out("SPECIFICGASCONSTANT", "SPECIFIC GAS CONSTANT", HEAT),
    left_out("ELECTRICALCONDUCTIVITY", "ELECTRICAL CONDUCTIVITY", HEAT),
    left_out("MAGNETICPERMEABILITY", "MAGNETIC PERMEABILITY", HEAT),
    left_out("VIEWFACTOR", "VIEWFACTOR", HEAT),
    left_out("VALUESATINFINITY", "VALUES AT INFINITY", HEAT),
    left_out("GAPHEATGENERATION", "GAP HEAT GENERATION", HEAT),
    left_out("CFD", "CFD", STATICS),
    left_out("ELECTROMAGNETICS", "ELECTROMAGNETICS", STATICS),
    left_out("DESIGNVARIABLES", "DESIGN VARIABLES", OPTIMISATION),
    left_out("DESIGNRESPONSE", "DESIGN RESPONSE", OPTIMISATION),
    left_out("OBJECTIVE", "OBJECTIVE", OPTIMISATION),
    left_out("CONSTRAINT", "CONSTRAINT", OPTIMISATION),
    left_out("FEASIBLEDIRECTION", "FEASIBLE DIRECTION", OPTIMISATION),
    left_out("GEOMETRICTOLERANCES", "GEOMETRIC TOLERANCES", OPTIMISATION),
    left_out("ROBUSTDESIGN", "ROBUST DESIGN", OPTIMISATION),
    left_out("DEPVAR", "DEPVAR", NONLINEAR),
    left_out("MOHRCOULOMB", "MOHR COULOMB", NONLINEAR),
    left_out("MOHRCOULOMBHARDENING", "MOHR COULOMB HARDENING", NONLINEAR),
    left_out("DEFORMATIONPLASTICITY", "DEFORMATION PLASTICITY", NONLINEAR),
    left_out("CHANGEPLASTIC", "CHANGE PLASTIC", NONLINEAR),
    left_out("CHANGEFRICTION", "CHANGE FRICTION", CONTACT),
    // What a model of retune cannot hold.
    refused(
        "CHANGEMATERIAL",
        "CHANGE MATERIAL",
        "materials that change between steps are not read; give those of the vibration",
    ),
    refused(
        "CHANGESOLIDSECTION",
        "CHANGE SOLID SECTION",
        "sections that change between steps are not read; give those of the vibration",
    ),
    refused(
        "CHANGECONTACTTYPE",
        "CHANGE CONTACT TYPE",
        "contact joins surfaces that the model would leave apart; give a TIE",
    ),
    refused(
        "SELECTCYCLICSYMMETRYMODES",
        "SELECT CYCLIC SYMMETRY MODES",
        "sectors of cyclic symmetry are not read; give the whole structure",
    ),
    refused("RETAINEDNODALDOFS", "RETAINED NODAL DOFS", "substructures come in by their matrices (`superelements`)"),
    refused(
        "SUBSTRUCTUREMATRIXOUTPUT",
        "SUBSTRUCTURE MATRIX OUTPUT",
        "substructures come in by their matrices (`superelements`)",
    ),
    refused("NETWORKMPC", "NETWORK MPC", "fluids are not read"),
    refused("USERSECTION", "USER SECTION", "sections of the user have no constants in the deck"),
    refused("REFINEMESH", "REFINE MESH", "a mesh that the solver refines is not read; give the refined deck"),
    refused("USEREFINEDMESH", "USE REFINED MESH", "a mesh that the solver refines is not read; give the refined deck"),
    refused("CRACKPROPAGATION", "CRACK PROPAGATION", "cracks that grow are not read"),
    refused("INITIALSTRAININCREASE", "INITIAL STRAIN INCREASE", "states of another analysis are not read"),
    refused(
        "PARAMETER",
        "PARAMETER",
        "parameters of the input file are expressions in Python; give the deck with their values",
    ),
    refused("NGEN", "NGEN", GENERATED),
    refused("NFILL", "NFILL", GENERATED),
    refused("NCOPY", "NCOPY", GENERATED),
    refused("NMAP", "NMAP", GENERATED),
    refused("ELGEN", "ELGEN", GENERATED),
    refused("ELCOPY", "ELCOPY", GENERATED),
    refused(
        "NODALTHICKNESS",
        "NODAL THICKNESS",
        "thicknesses at nodes are not read; give SHELL SECTIONs by element sets",
    ),
    refused("DISTRIBUTION", "DISTRIBUTION", "values by element are not read; give sections by element sets"),
    refused("DISTRIBUTIONTABLE", "DISTRIBUTION TABLE", "values by element are not read; give sections by element sets"),
    refused("CONTACTPAIR", "CONTACT PAIR", "contact joins surfaces that the model would leave apart; give a TIE"),
    refused("CONTACT", "CONTACT", "contact joins surfaces that the model would leave apart; give a TIE"),
    refused("CLEARANCE", "CLEARANCE", "contact is not linear; give a TIE"),
    refused("PRE-TENSIONSECTION", "PRE-TENSION SECTION", "bolts under preload are not read; give a TIE"),
    refused("EMBEDDEDELEMENT", "EMBEDDED ELEMENT", "embedded elements are not read; give a TIE"),
    refused(
        "CYCLICSYMMETRYMODEL",
        "CYCLIC SYMMETRY MODEL",
        "sectors of cyclic symmetry are not read; give the whole structure",
    ),
    refused("FASTENER", "FASTENER", "fasteners are not read; give SPRING2 or COUPLING"),
    refused("MEMBRANESECTION", "MEMBRANE SECTION", "membranes are not read; give SHELL SECTION"),
    refused("COHESIVESECTION", "COHESIVE SECTION", "cohesive elements are not read; give a TIE"),
    refused("GAP", "GAP", "contact is not linear; give a SPRINGA for a gap that is closed"),
    refused("JOINT", "JOINT", "flexible joints are not read; give SPRING2"),
    refused("SHELLTOSOLIDCOUPLING", "SHELL TO SOLID COUPLING", "give a COUPLING of the edge to a node, or a TIE"),
    refused("SUBMODEL", "SUBMODEL", "submodels take their boundary from another analysis"),
    refused(
        "SUBSTRUCTUREGENERATE",
        "SUBSTRUCTURE GENERATE",
        "substructures come in by their matrices (`superelements`)",
    ),
    refused(
        "SUBSTRUCTUREPROPERTY",
        "SUBSTRUCTURE PROPERTY",
        "substructures come in by their matrices (`superelements`)",
    ),
    refused("MATRIXINPUT", "MATRIX INPUT", "matrices come in by `superelements`"),
    refused("MATRIXASSEMBLE", "MATRIX ASSEMBLE", "matrices come in by `superelements`"),
    refused("USERELEMENT", "USER ELEMENT", "elements of the user have no matrices in the deck"),
    refused("UELPROPERTY", "UEL PROPERTY", "elements of the user have no matrices in the deck"),
    refused("USERMATERIAL", "USER MATERIAL", "materials of the user have no constants in the deck; give ELASTIC"),
    refused("HYPERELASTIC", "HYPERELASTIC", "hyperelastic materials are not read; give the ELASTIC of small strains"),
    refused("HYPERFOAM", "HYPERFOAM", "hyperelastic materials are not read; give the ELASTIC of small strains"),
    refused("REBARLAYER", "REBAR LAYER", "bars within shells are not read; give beams on the same nodes"),
    refused("REBAR", "REBAR", "bars within elements are not read; give beams on the same nodes"),
    refused(
        "NONSTRUCTURALMASS",
        "NONSTRUCTURAL MASS",
        "mass spread over sets is not read; give it in densities or by MASS",
    ),
    refused("IMPORT", "IMPORT", "states of another analysis are not read; give the whole deck"),
    refused(
        "MODELCHANGE",
        "MODEL CHANGE",
        "elements that come and go are not read; give the deck of the structure as it vibrates",
    ),
    refused("FLUIDSECTION", "FLUID SECTION", "fluids are not read"),
    refused("ACOUSTICMEDIUM", "ACOUSTIC MEDIUM", "fluids are not read"),
    refused(
        "BEAMFLUIDINERTIA",
        "BEAM FLUID INERTIA",
        "give the water's mass as `air_mass_y`, `air_mass_z` of the section",
    ),
];

/// The rule of a keyword.
pub(super) fn rule(name: &str) -> Option<&'static KeywordRule> {
    KEYWORDS.iter().find(|r| r.name == name)
}

/// Whether a keyword that is read belongs into a step.
pub(super) fn is_of_steps(name: &str) -> bool {
    matches!(name, "BOUNDARY" | "FREQUENCY")
}

/// Parameters of keywords that are read: those that are honoured, and those that say nothing of small vibrations.
const PARAMETERS: &[(&str, &[&str])] = &[
    ("HEADING", &[]),
    ("NODE", &["NSET", "SYSTEM", "INPUT"]),
    ("ELEMENT", &["TYPE", "ELSET", "INPUT"]),
    ("NSET", &["NSET", "ELSET", "GENERATE", "INSTANCE", "INTERNAL", "UNSORTED", "INPUT"]),
    ("ELSET", &["ELSET", "GENERATE", "INSTANCE", "INTERNAL", "UNSORTED", "INPUT"]),
    (
        "SURFACE",
        &[
            "NAME",
            "TYPE",
            "INTERNAL",
            "COMBINE",
            "CROP",
            "REGIONTYPE",
            "INPUT",
            "NOTHICK",
            "NOOFFSET",
            "TRIM",
            "PROPERTY",
        ],
    ),
    ("PART", &["NAME"]),
    ("ENDPART", &[]),
    ("ASSEMBLY", &["NAME"]),
    ("ENDASSEMBLY", &[]),
    ("INSTANCE", &["NAME", "PART"]),
    ("ENDINSTANCE", &[]),
    ("SYSTEM", &[]),
    ("TRANSFORM", &["NSET", "TYPE"]),
    ("ORIENTATION", &["NAME", "SYSTEM", "DEFINITION"]),
    ("MATERIAL", &["NAME", "DESCRIPTION", "RTOL", "SRATEFACTOR"]),
    ("ELASTIC", &["TYPE", "MODULI", "DEPENDENCIES", "INPUT"]),
    ("DENSITY", &["DEPENDENCIES", "INPUT"]),
    (
        "SOLIDSECTION",
        &["ELSET", "MATERIAL", "ORIENTATION", "COMPOSITE", "CONTROLS", "SYMMETRIC", "STACKDIRECTION", "LAYUP"],
    ),
    (
        "SHELLSECTION",
        &[
            "ELSET",
            "MATERIAL",
            "ORIENTATION",
            "COMPOSITE",
            "OFFSET",
            "CONTROLS",
            "NODALTHICKNESS",
            "SHELLTHICKNESS",
            "STACKDIRECTION",
            "POISSON",
            "SECTIONINTEGRATION",
            "TEMPERATURE",
            "THICKNESSMODULUS",
            "LAYUP",
            "SYMMETRIC",
            "DENSITY",
        ],
    ),
    (
        "SHELLGENERALSECTION",
        &[
            "ELSET",
            "MATERIAL",
            "ORIENTATION",
            "COMPOSITE",
            "OFFSET",
            "CONTROLS",
            "NODALTHICKNESS",
            "SHELLTHICKNESS",
            "STACKDIRECTION",
            "POISSON",
            "THICKNESSMODULUS",
            "LAYUP",
            "SYMMETRIC",
            "DENSITY",
            "USER",
            "ZERO",
            "BENDINGONLY",
            "MEMBRANEONLY",
        ],
    ),
    (
        "BEAMSECTION",
        &["ELSET", "MATERIAL", "SECTION", "POISSON", "TEMPERATURE", "ROTARYINERTIA", "OFFSET1", "OFFSET2", "LUMPED"],
    ),
    (
        "BEAMGENERALSECTION",
        &["ELSET", "MATERIAL", "SECTION", "DENSITY", "POISSON", "ZERO", "ROTARYINERTIA", "LUMPED", "DEPENDENCIES"],
    ),
    ("TRANSVERSESHEARSTIFFNESS", &[]),
    ("TRANSVERSESHEAR", &[]),
    ("CENTROID", &[]),
    ("SHEARCENTER", &[]),
    ("MASS", &["ELSET", "TYPE", "ORIENTATION", "ALPHA", "COMPOSITE"]),
    ("ROTARYINERTIA", &["ELSET", "ORIENTATION", "ALPHA", "COMPOSITE"]),
    ("SPRING", &["ELSET", "ORIENTATION", "NONLINEAR", "COMPLEXSTIFFNESS", "DEPENDENCIES", "RTOL"]),
    ("DASHPOT", &["ELSET", "ORIENTATION", "NONLINEAR", "DEPENDENCIES"]),
    (
        "TIE",
        &[
            "NAME",
            "ADJUST",
            "POSITIONTOLERANCE",
            "TYPE",
            "NOROTATION",
            "NOTHICKNESS",
            "CYCLICSYMMETRY",
            "MULTIPHYSICS",
            "FLUIDSURFACE",
            "TIEDNSET",
        ],
    ),
    ("COUPLING", &["CONSTRAINTNAME", "REFNODE", "SURFACE", "INFLUENCERADIUS", "ORIENTATION"]),
    ("KINEMATIC", &[]),
    ("DISTRIBUTING", &["WEIGHTINGMETHOD", "COUPLING"]),
    ("KINEMATICCOUPLING", &["REFNODE", "ORIENTATION"]),
    ("DISTRIBUTINGCOUPLING", &["ELSET", "NSET"]),
    ("MPC", &["USER", "MODE", "INPUT"]),
    (
        "RIGIDBODY",
        &["REFNODE", "ELSET", "NSET", "TIENSET", "PINNSET", "ROTNODE", "POSITION", "ISOTHERMAL", "ANALYTICALSURFACE"],
    ),
    ("EQUATION", &["INPUT"]),
    ("CONNECTORSECTION", &["ELSET", "BEHAVIOR", "CONTROLS"]),
    ("CONNECTORBEHAVIOR", &["NAME", "EXTRAPOLATION", "REGULARIZE", "INTEGRATION"]),
    (
        "CONNECTORELASTICITY",
        &["COMPONENT", "RIGID", "NONLINEAR", "DEPENDENCIES", "INDEPENDENTCOMPONENTS", "FREQUENCYDEPENDENCE"],
    ),
    (
        "BOUNDARY",
        &[
            "OP",
            "TYPE",
            "FIXED",
            "AMPLITUDE",
            "LOADCASE",
            "USER",
            "SUBMODEL",
            "BASENAME",
            "TIMEDELAY",
            "REAL",
            "IMAGINARY",
            "REGIONTYPE",
            "BLOCKING",
            "STEP",
            "INCREMENT",
            "DATASET",
        ],
    ),
    (
        "STEP",
        &[
            "NAME",
            "PERTURBATION",
            "NLGEOM",
            "INC",
            "INCF",
            "AMPLITUDE",
            "UNSYMM",
            "CONVERTSDI",
            "EXTRAPOLATION",
            "SOLVER",
            "DIRECT",
            "THERMALNETWORK",
            "FREQUENCY",
            "SUBSTRUCTURE",
        ],
    ),
    ("ENDSTEP", &[]),
    (
        "FREQUENCY",
        &[
            "EIGENSOLVER",
            "SIM",
            "ACOUSTICCOUPLING",
            "NORMALIZATION",
            "NSET",
            "SOLVER",
            "STORAGE",
            "GLOBAL",
            "CYCMPC",
            "PROPERTYEVALUATION",
            "RESIDUALMODES",
            "DAMPINGPROJECTION",
            "NUMBERINTERVAL",
            "RECOVER",
            "ALPHA",
        ],
    ),
];

/// A parameter of a keyword that is read without knowing it: its name, and the nearest that is known.
pub(super) fn unknown_parameter<'k>(keyword: &retune::deck::Keyword<'k>) -> Option<(&'k str, String)> {
    let known = PARAMETERS.iter().find(|p| p.0 == keyword.name())?.1;
    let other = keyword.parameters().find(|p| !known.contains(p))?;
    Some((other, retune::catalogue::did_you_mean(other, known.iter().copied())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_keyword_that_is_read_has_its_parameters() {
        for rule in KEYWORDS.iter().filter(|r| matches!(r.use_of, KeywordUse::Read(_))) {
            assert!(PARAMETERS.iter().any(|p| p.0 == rule.name), "{}", rule.name);
        }
        for (name, _) in PARAMETERS {
            assert!(matches!(rule(name).map(|r| r.use_of), Some(KeywordUse::Read(_))), "{name}");
        }
    }
}
