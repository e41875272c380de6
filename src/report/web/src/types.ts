/** The report's data as they stand in the page: the JSON form of `ReportData` in `src/report/data.rs`, schema 2. */

/** Base64 text of little-endian 32-bit floats; see `decode.ts`. */
export type Floats = string;
/** A number; NaN and infinity come as null. */
export type Num = number | null;
export type Vec3 = [number, number, number];

export interface Spectrum { log_low: number; log_step: number; data: string }
export interface Named { name: string; text: string }
export type Level = "good" | "warning" | "bad" | "neutral";

export interface Meta {
  title: string;
  subtitle: string;
  verdict: { sentence: string; number: string; number_label: string; level: Level } | null;
  created: string | null;
  versions: Named[];
  seeds: Named[];
  commands: string[];
  files: { role: string; path: string; sha256: string }[];
  data_items: { name: string; origin: string; source: string }[];
  warnings: string[];
}

export interface Property { name: string; value: string }
export interface Element {
  name: string; kind: string; nodes: number[]; group?: string; parameters?: string[];
  property_set?: number; properties?: Property[]; z_axis?: Vec3;
}
export interface Field {
  name: string; unit: string; on: "elements" | "nodes" | "sensors";
  scale: "sequential" | "diverging" | "unit"; anchor?: number; about: string; values: Floats;
}
export interface Sensor { name: string; position: Vec3; direction: Vec3; is_rotation: boolean; attached_to: string }
export interface Exciter { name: string; position: Vec3; direction: Vec3 }
export interface PointMass {
  name: string; node: number; mass: Num; offset: Vec3 | null; parameters: string[]; properties: Property[];
}
export interface Structure {
  up: number | null;
  nodes: { name: string; position: Vec3 }[];
  elements: Element[];
  property_sets: { name: string; properties: Property[] }[];
  rigid_links: { name: string; master: number; slaves: number[] }[];
  masses: PointMass[];
  supports: { node: number; dofs: string }[];
  sensors: Sensor[];
  exciters: Exciter[];
  trace_lines: number[][];
  fields: Field[];
}

export interface ModelMode {
  label: string; frequency_hz: number; damping_ratio: Num;
  displacement: Floats; displacement_imag?: Floats; rotation?: Floats;
  at_sensors?: Floats; at_sensors_imag?: Floats;
}
export interface TestMode {
  label: string; frequency_hz: number; frequency_sd: Num; damping_ratio: Num; origin: string;
  at_sensors?: Floats; at_sensors_imag?: Floats; expanded?: Floats;
}
export interface Modes { model: ModelMode[]; test: TestMode[] }

export interface Pair {
  label: string; test_mode: number | null; model_mode: number | null;
  test_hz: number; model_hz: number; error: number; mac: Num; test_damping: Num;
  passes: boolean | null; pass_probability: Num;
}
export interface LabelledMatrix {
  title: string; row_axis: string; column_axis: string; rows: string[]; columns: string[]; values: Num[][];
}
export interface Comparison {
  pairs: Pair[]; pairs_before: Pair[]; unpaired_test: number[]; unpaired_reasons?: string[]; unpaired_model: number[];
  criteria: string; frequency_band: number;
  mac: LabelledMatrix | null; mac_before: LabelledMatrix | null;
  cross_orthogonality?: LabelledMatrix; auto_orthogonality?: LabelledMatrix; orthogonality_note?: string;
  comac: Floats | null; comac_before: Floats | null;
}

export interface Band { name: string; from_hz: number; to_hz: number; csac: Num; csf: Num }
export interface Channel {
  response: string; reference: string; sensor: number | null; exciter?: number; sign?: number;
  measured?: Spectrum; model?: Spectrum; before?: Spectrum; coherence?: Floats;
  frac: Num[]; frac_before?: Num[];
}
export interface Frfs {
  quantity: string; unit: string; origin: string; note: string; frequency_hz: Floats; bands: Band[]; channels: Channel[];
  fdac: LabelledMatrix[]; fdac_before: LabelledMatrix[];
}

export interface History { name: string; evaluations: number[]; best_cost: Num[] }
export interface Parameter {
  name: string; unit: string; before: number; after: Num; lower: Num; upper: Num;
  interval: [number, number] | null; interval_label: string; at_bound: "lower" | "upper" | null; determined: Num;
}
export interface Combination { weights: [string, number][]; relative_singular_value: Num; meaning: string }
export interface MassProperty {
  name: string; unit: string; target: Num; tolerance: Num; before: Num; after: Num; within: boolean | null; source: string;
}
export interface Update {
  optimizer: string; objective: string; termination: string; evaluations: Num; cost_before: Num; cost_after: Num;
  histories: History[]; parameters: Parameter[]; correlation: LabelledMatrix | null;
  unidentifiable: Combination[]; sensitivities: LabelledMatrix[]; mass_properties: MassProperty[];
}

export interface Step { name: string; misfit: number; per_mode: Num[]; held_out: Num; held_out_per_mode?: Num[]; note: string }
export interface Steps { measure: string; noise_floor: Num; mode_labels: string[]; steps: Step[] }

export interface Rejected { hz: number; damping: number; reason: string }
export interface Diagram {
  name: string; hz: Floats; damping: Floats; order: number[]; mark: number[]; column: number[]; chosen: number[]; discarded: Rejected[];
}
export interface IdentifiedMode { hz: number; hz_sd: number; damping: Num; damping_sd: Num; mpc: Num; orders: number; remark: string }
export interface Identification {
  method: string; unit: string; frequency_hz: Floats; cmif: Floats[]; diagrams: Diagram[]; modes: IdentifiedMode[];
}

export interface Sampled {
  name: string; unit: string; lower: number; upper: number; mean: number; sd: number; quantiles: [number, number, number, number, number];
  correlations: Num[]; values: Floats;
}
export interface Posterior { parameters: Sampled[]; samples: number; log_evidence: number; log_evidence_se: number; note: string }

export interface Place { text: string; nodes: number[]; elements: number[]; sensors: number[] }
export interface Suspect { place: Place; above_noise: Num; relative_energy: Num; p_value: Num }
export interface Localization { sentence: string; stands_out: boolean; p_family: Num; elements: Suspect[]; groups: Suspect[] }

export interface Estimate { quantity: string; value: Num; unit: string; interval: [number, number] | null; interval_label: string }
export interface Hypothesis {
  id: string; category: "effect" | "measurement" | "none" | "other"; kind: string; summary: string; place: Place;
  probability: Num; log_bayes_factor: Num; misfit_before: Num; misfit_after: Num;
  held_out_before: Num; held_out_after: Num; estimates: Estimate[]; tied_with: string[]; evidence_for: string[]; evidence_against: string[]; patch: string;
}
export interface Measurement {
  what: string; why: string; separates: string[]; expected_log_bayes_factor: Num; place: Place | null;
}
export interface Diagnosis {
  title: string;
  outcome: "adequate" | "missing-effect" | "measurement-fault" | "several-effects" | "tied" | "unexplained" | "noise-or-model";
  sentence: string; p_value: Num; alarm_level: Num; screened: Num; tried: string;
  misfit: Num; degrees_of_freedom: Num; noise_factor: Num;
  hypotheses: Hypothesis[]; next_measurements: Measurement[]; remainder: string; remainder_place: Place | null;
  warnings: string[];
}

/** Base64 text of little-endian 64-bit floats. */
export type Doubles = string;
export interface LiveAccuracy { points: number; frequency: Num[]; mac: Num[] }
export interface LiveParameter {
  name: string; unit: string; unit_factor: number; value: number; initial?: number; range: [number, number]; origin: number; description: string;
}
export interface LiveVersion { name: string; values: [number, number][] }
export interface LiveHypothesis {
  id: string; kind: string; sizes: number[]; estimates: number[]; probability: number; alters: number[]; accuracy: LiveAccuracy; test?: LiveTestEdit;
}
export interface LiveEntries { at: number[]; values: Doubles }
export interface LiveTestEdit {
  is_angle: boolean; frequency: LiveEntries; frequency_sd: LiveEntries; shape: LiveEntries; shape_sd: LiveEntries; sensors: LiveEntries; remedy: string;
}
export type LiveMatrix = { lower: Doubles } | { sum: Doubles };
export interface LiveTerm { powers: [number, number][]; from_zero: boolean; stiffness?: LiveMatrix; mass?: LiveMatrix }
export interface LiveSymmetry { mirror: Doubles; gram: Doubles }
export type LivePlan = "free" | "aside" | { fixed: number } | { ranked: number };
export interface LiveTestMode {
  label: string; frequency_hz: number; frequency_sd: number; shape: Doubles; shape_sd: Doubles; damping?: number; family?: string; plan: LivePlan;
  followed?: Doubles; followed_alone: boolean;
}
export interface LivePairing { by: string; min_mac: number; frequency_window: Num; same_family_only: boolean }
export interface Live {
  n: number; is_complete: boolean; n_rigid: number; shift: number; n_elastic: number;
  parameters: LiveParameter[]; versions?: LiveVersion[]; hypotheses: LiveHypothesis[]; left_out?: Named[]; terms: LiveTerm[];
  sensors: Doubles; symmetry?: LiveSymmetry; displacement: Floats; rotation?: Floats;
  test: LiveTestMode[]; damping: number; pairing: LivePairing; n_data: number; not_computed: number; accuracy: LiveAccuracy;
}

export interface ReportData {
  schema: number; meta: Meta; structure?: Structure; modes: Modes; comparison?: Comparison; frfs?: Frfs;
  identification?: Identification; live?: Live; update?: Update; steps?: Steps; posterior?: Posterior; localization?: Localization; diagnosis?: Diagnosis; earlier_diagnoses?: Diagnosis[];
}
