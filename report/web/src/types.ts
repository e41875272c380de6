/** The report's data as they stand in the page. The types are generated from the schema of `report/src/data.rs` by `build.mjs`. */

export type * from "../types/data";

/** A number; NaN and infinity come as null. */
export type Num = number | null;
export type Vec3 = [number, number, number];
