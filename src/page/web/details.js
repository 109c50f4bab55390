"use strict";
// What is selected: a contact with its record, or a vertex with its contacts and the reasons for none.

/** A value as JSON has it; of a page with rounded numbers, the digits that mean something. */
function shownValue(value, rounded = false) {
  if (Array.isArray(value)) return value.map((one) => shownValue(one, rounded)).join("  ");
  return String(rounded && typeof value === "number" ? Number(value.toPrecision(6)) : value);
}

function keyTable(entries, rounded = false) {
  return element("div", { class: "scroll" }, element("table", {}, element("tbody", {},
    ...entries.map(([key, value]) => element("tr", {}, element("th", {}, key),
      element("td", {}, value instanceof Node ? value : shownValue(value, rounded)))))));
}

class Details {
  constructor(data, place, player) {
    this.data = data;
    this.place = place;
    this.player = player;
  }

  link(text, selection) {
    return element("a", { role: "button", tabindex: 0, onclick: () => this.player.select(selection),
      onkeydown: (event) => { if (event.key === "Enter") this.player.select(selection); } }, text);
  }
  body(b) { return this.link(`${b} ${this.data.bodies[b].name}`, { body: b }); }

  show(frame, { contact, body, vertex }) {
    const parts = contact !== undefined ? this.#contact(frame, contact)
      : vertex !== undefined ? this.#vertex(frame, body, vertex)
      : body !== undefined ? this.#body(frame, body) : this.#nothing(frame);
    this.place.replaceChildren(...parts);
  }

  #nothing(frame) {
    const [begin, end] = this.data.contactRange(frame);
    const parts = [element("p", {}, `Frame ${frame} has ${end - begin} contacts. Click a contact, or a vertex of a body.`)];
    const figures = Object.entries(this.data.figures[frame] ?? {})
      .filter(([, value]) => typeof value !== "object").map(([key, value]) => [key.replaceAll("_", " "), value]);
    if (figures.length) parts.push(element("h2", {}, "The frame"), keyTable(figures));
    const times = Object.entries(this.data.figures[frame]?.ms ?? {});
    if (times.length) parts.push(element("h2", {}, "Time [ms]"), keyTable(times));
    return parts;
  }

  #contact(frame, number) {
    const c = this.data.contact(frame, number), of = c[c.source], against = c[c.source === "a" ? "b" : "a"];
    const far = shownValue(Math.abs(c.distance), this.data.rounded), depth = c.distance > 0 ? `${far} apart` : `${far} deep`;
    const what = c.edge_end === undefined
      ? this.link(`vertex ${c.vertex}`, { body: of, vertex: c.vertex })
      : element("span", {}, "the edge from ", this.link(`vertex ${c.vertex}`, { body: of, vertex: c.vertex }),
        " to ", this.link(`vertex ${c.edge_end}`, { body: of, vertex: c.edge_end }));
    const record = { ...c };
    record.a = this.body(c.a);
    record.b = this.body(c.b);
    const [begin, end] = this.data.contactRange(frame), pair = [];
    for (let i = begin; i < end; ++i)
      if (this.data.columns.contact_a[i] === c.a && this.data.columns.contact_b[i] === c.b) pair.push(i - begin);
    return [
      element("h2", {}, `Contact ${number} of frame ${frame}`),
      element("p", { id: "explanation" }, what, " of ", this.body(of), ` is ${depth} at triangle ${c.triangle} of `, this.body(against),
        `, ${FOUND_TEXTS[c.found]}${c.reprojected ? ", then moved to the closest point" : ""}.`),
      keyTable(Object.entries(record), this.data.rounded),
      this.data.rounded ? element("p", { class: "faint" }, "Points, normals and weights are rounded to 16 bits of a mesh's "
        + "features on this page, and depths to float32, as there are many; pierce detect and replay have them whole.") : null,
      element("h2", {}, `The pair's contacts: ${pair.length}`),
      element("p", {}, ...pair.flatMap((k) => [this.link(`c${k}`, { contact: k }), " "])),
    ].filter(Boolean);
  }

  #vertex(frame, body, vertex) {
    const data = this.data, c = data.columns, [begin, end] = data.contactRange(frame), own = [];
    for (let i = begin; i < end; ++i) {
      const of = c.contact_flags[i] & 1 ? c.contact_b[i] : c.contact_a[i];
      if (of === body && (c.contact_vertex[i] === vertex || c.contact_edge_end[i] === vertex + 1)) own.push(i - begin);
    }
    const reasons = data.reasonsOf(frame, body, vertex);
    let why;
    if (reasons.length) why = reasons.map(({ other, text }) => element("p", { class: "reason" }, "Against ", this.body(other), ": ", text));
    else if (data.isLeftOut(frame, body)) why = [element("p", { class: "reason" },
      "No contact: the body was left out of the step. It is not finite, or its world is not active.")];
    else if (!data.has_reasons) why = [element("p", {}, "This page was made without reasons.")];
    else if (own.length) why = [];
    else if (!data.has_all_reasons && data.bodies.some((one) => one.sheet))
      why = [element("p", {}, "Reasons about sheets of this size are not on this page.")];
    else why = [element("p", { class: "reason" }, "No contact: the vertex is outside of the boxes of all other bodies of the step.")];
    const mesh = data.meshOf(frame, body), title = element("h2", {}, `Vertex ${vertex} of body `, this.body(body));
    if (!data.hasVertex(frame, body, vertex))
      return [title, element("p", {}, mesh ? "The body's mesh has no such vertex in this frame." : "The body is not there in this frame.")];
    const other = reasons[0]?.other ?? "OTHER";
    return [
      title, keyTable([["position", data.vertexAt(frame, body, vertex)], ["patch", mesh.patches[vertex]]]),
      element("h2", {}, own.length ? `Its contacts: ${own.length}` : "Why it has no contact"),
      element("p", {}, ...own.flatMap((k) => [this.link(`c${k}`, { contact: k }), " "])), ...why,
      ...(data.made_with.explain ? [element("p", { class: "faint" }, "The whole answer:"),
        element("code", {}, `${data.made_with.explain} --frame ${frame} --bodies ${body} ${other} --vertex ${vertex}`)] : []),
    ];
  }

  #body(frame, body) {
    const data = this.data, c = data.columns, [begin, end] = data.contactRange(frame), others = new Map();
    let deepest = 0;
    for (let i = begin; i < end; ++i) {
      const [a, b] = [c.contact_a[i], c.contact_b[i]];
      if (a !== body && b !== body) continue;
      const other = a === body ? b : a;
      if (!others.has(other)) others.set(other, []);
      others.get(other).push(i - begin);
      deepest = Math.max(deepest, -c.contact_distance[i]);
    }
    const mesh = data.meshOf(frame, body);
    return [
      element("h2", {}, `Body ${body} ${data.bodies[body].name}`),
      keyTable([["motion", data.bodies[body].motion], ["sheet", data.bodies[body].sheet],
        ...(mesh ? [["mesh", mesh.name], ["vertices", mesh.vertices.length / 3], ["triangles", mesh.triangles.length / 3],
          ["closed", mesh.closed]] : []),
        ...(mesh && data.bodies[body].motion !== "deforming" ? [["pose", Array.from(data.poseOf(frame, body))]] : []),
        ["deepest contact", deepest]]),
      element("h2", {}, `In contact with ${others.size} ${others.size === 1 ? "body" : "bodies"}`),
      ...[...others].map(([other, list]) => element("p", {}, this.body(other), `, ${list.length}: `,
        ...list.slice(0, MOST_LINKS).flatMap((k) => [this.link(`c${k}`, { contact: k }), " "]), list.length > MOST_LINKS ? "…" : "")),
    ];
  }
}
const MOST_LINKS = 40;

/** The tab "About": what the page was made with. */
function showAbout(data, place) {
  const { tables, notes, explain, ...rest } = data.made_with;
  for (const table of tables ?? [])
    place.append(element("h2", {}, table.title), element("div", { class: "scroll" }, element("table", { class: "wide" },
      element("thead", {}, element("tr", {}, ...table.columns.map((name) => element("th", {}, name)))),
      element("tbody", {}, ...table.rows.map((row) => element("tr", {}, ...row.map((cell) => element("td", {}, shownValue(cell, true)))))))));
  if (notes?.length) place.append(element("h2", {}, "Notes"), ...notes.map((note) => element("p", {}, note)));
  for (const [title, values] of Object.entries(rest))
    if (values && typeof values === "object")
      place.append(element("h2", {}, title), keyTable(Object.entries(values)
        .map(([key, value]) => [key.replaceAll("_", " "), value !== null && typeof value === "object" && !Array.isArray(value) ? JSON.stringify(value) : value])));
  place.append(element("h2", {}, "page"), keyTable([["frames", data.frameCount], ["bodies", data.bodies.length],
    ["contacts", data.columns.contact_begin[data.frameCount]], ["numbers", data.rounded ? "rounded: the page would be large otherwise" : "exact"]]));
}
