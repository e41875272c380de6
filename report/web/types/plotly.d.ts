/** The part of plotly.js that the report uses. */
declare module "plotly.js-basic-dist-min" {
  export type Trace = Record<string, unknown>;
  export type Layout = Record<string, unknown>;
  export interface PlotlyApi {
    react(element: HTMLElement, data: Trace[], layout: Layout, config?: Record<string, unknown>): Promise<unknown>;
    purge(element: HTMLElement): void;
  }
  const Plotly: PlotlyApi;
  export default Plotly;
}
