/** What a picked thing is, in words. */

import { significant } from "./format";
import type { Hit, Kind } from "./pick";
import type { Place, Property, Structure, Vec3 } from "./types";

function point(p: readonly number[]): string {
  return `${p.map((v) => significant(v, 4)).join(", ")} m`;
}

const WORDS: Record<Kind, string> = {
  node: "Node", element: "Element", sensor: "Sensor", mass: "Mass", exciter: "Exciter", support: "Support", link: "Rigid link",
};

/** Name of what was hit. */
export function nameOf(s: Structure, { kind, index }: Hit): string {
  const lists = { node: s.nodes, element: s.elements, sensor: s.sensors, mass: s.masses, exciter: s.exciters, link: s.rigid_links };
  const name = kind === "support" ? s.nodes[s.supports[index]?.node ?? -1]?.name : lists[kind][index]?.name;
  return name ?? String(index);
}

/** Kind and name on one line. */
export function titleOf(s: Structure, hit: Hit): string {
  const type = hit.kind === "element" ? s.elements[hit.index]?.kind : "";
  return `${WORDS[hit.kind]} ${nameOf(s, hit)}${type ? ` (${type})` : ""}`;
}

function massRows(s: Structure, index: number): Property[] {
  const m = s.masses[index];
  if (!m) return [];
  const rows: Property[] = [];
  if (m.mass != null) rows.push({ name: "mass", value: `${significant(m.mass, 4)} kg` });
  if (m.offset && Math.hypot(...m.offset) > 0) rows.push({ name: "offset", value: point(m.offset) });
  rows.push(...m.properties);
  if (m.parameters.length) rows.push({ name: "parameters", value: m.parameters.join(", ") });
  return rows;
}

/** Everything known about what was hit. */
export function rowsOf(s: Structure, { kind, index }: Hit): Property[] {
  const node = (i: number): string => s.nodes[i]?.name ?? String(i);
  switch (kind) {
    case "node": {
      const rows: Property[] = [{ name: "position", value: point(s.nodes[index]!.position) }];
      s.masses.forEach((m, i) => {
        if (m.node === index) rows.push({ name: "point mass", value: m.name }, ...massRows(s, i));
      });
      const support = s.supports.find((b) => b.node === index);
      if (support) rows.push({ name: "supported", value: support.dofs });
      const link = s.rigid_links.find((l) => l.master === index || l.slaves.includes(index));
      if (link) rows.push({ name: link.master === index ? "master of" : "follows in", value: link.name });
      return rows;
    }
    case "element": {
      const e = s.elements[index]!;
      const rows: Property[] = [{ name: "nodes", value: e.nodes.map(node).join(" – ") }];
      if (e.nodes.length === 2) {
        const [a, b] = e.nodes.map((i) => s.nodes[i]?.position) as [Vec3 | undefined, Vec3 | undefined];
        if (a && b) rows.push({ name: "length", value: `${significant(Math.hypot(...a.map((v, k) => v - b[k]!)), 4)} m` });
      }
      if (e.group) rows.push({ name: "group", value: e.group });
      if (e.parameters?.length) rows.push({ name: "parameters", value: e.parameters.join(", ") });
      const set = e.property_set == null ? null : s.property_sets[e.property_set];
      if (set?.name) rows.push({ name: "section", value: set.name });
      if (set) rows.push(...set.properties);
      rows.push(...(e.properties ?? []));
      return rows;
    }
    case "sensor": {
      const sensor = s.sensors[index]!;
      const rows: Property[] = [
        { name: "position", value: point(sensor.position) },
        { name: sensor.is_rotation ? "reads rotation about" : "reads along", value: sensor.direction.map((v) => significant(v, 3)).join(", ") },
      ];
      if (sensor.attached_to) rows.push({ name: "attached to", value: sensor.attached_to });
      return rows;
    }
    case "mass": return [{ name: "node", value: node(s.masses[index]!.node) }, ...massRows(s, index)];
    case "exciter": {
      const e = s.exciters[index]!;
      return [{ name: "position", value: point(e.position) }, { name: "acts along", value: e.direction.map((v) => significant(v, 3)).join(", ") }];
    }
    case "support": return [{ name: "holds", value: s.supports[index]!.dofs }];
    case "link": {
      const link = s.rigid_links[index]!;
      return [{ name: "master", value: node(link.master) }, { name: "nodes that follow", value: link.slaves.map(node).join(", ") }];
    }
  }
}

/** The place of what was hit, for marking it. */
export function placeOf(s: Structure, { kind, index }: Hit): Place {
  const place: Place = { text: "", on_mesh: "", nodes: [], elements: [], sensors: [] };
  if (kind === "node") place.nodes = [index];
  if (kind === "element") place.elements = [index];
  if (kind === "sensor") place.sensors = [index];
  if (kind === "mass") place.nodes = [s.masses[index]!.node];
  if (kind === "support") place.nodes = [s.supports[index]!.node];
  if (kind === "link") place.nodes = [s.rigid_links[index]!.master, ...s.rigid_links[index]!.slaves];
  return place;
}
