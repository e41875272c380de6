/** The text of a script that is bundled alone; see `build.mjs`. */
declare module "worker:*" {
  const source: string;
  export default source;
}
