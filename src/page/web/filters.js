"use strict";
// Which contacts are shown, and what else: the tab "Show".

/** An element with attributes and children; text stays text. */
function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
    else if (value === true) made.setAttribute(key, "");
    else if (value !== false && value !== undefined) made.setAttribute(key, value);
  }
  made.append(...children.filter((child) => child !== undefined && child !== null));
  return made;
}

class Filters {
  constructor(data, place, onChange) {
    this.data = data;
    this.onChange = onChange;
    this.found = new Set(FOUND);
    this.vertices = this.edges = true;
    this.bodies = [undefined, undefined];
    this.least = 0;
    this.ages = [0, Infinity];
    this.colors = "depth";
    this.place = place;
  }

  /** Adds the controls; `views`: [label, initially on, what to do with a switch]. */
  build(views, opacity, arrows) {
    const used = new Set(this.data.columns.contact_found);
    const box = (label, on, change) => {
      const input = element("input", { type: "checkbox", checked: on, onchange: () => { change(input.checked); this.onChange(); } });
      return element("label", {}, input, label);
    };
    const number = (label, value, change, placeholder) => {
      const input = element("input", { type: "text", inputmode: "decimal", value, placeholder, onchange: () => { change(input.value.trim()); this.onChange(); } });
      return element("label", { class: "row" }, label, input);
    };
    const slider = (label, low, high, value, change) => {
      const input = element("input", { type: "range", min: low, max: high, step: "any", value, oninput: () => { change(Number(input.value)); this.onChange(); } });
      return element("label", { class: "row" }, label, input);
    };
    const body = (k) => (text) => { this.bodies[k] = text === "" ? undefined : this.bodyNamed(text); };
    const colors = element("select", { onchange: () => { this.colors = colors.value; this.onChange(); } },
      element("option", { value: "depth" }, "deepest contact"), element("option", { value: "body" }, "body"),
      element("option", { value: "plain" }, "nothing"));
    this.place.append(
      element("h2", {}, "In the scene"), ...views.map(([label, on, change]) => box(label, on, change)),
      element("label", { class: "row" }, "bodies coloured by", colors),
      slider("bodies' opacity", 0.05, 1, 1, opacity), slider("arrows' length", 0, 4, 1, arrows),
      element("h2", {}, "Contacts of"),
      box("vertices", true, (on) => { this.vertices = on; }), box("edges", true, (on) => { this.edges = on; }),
      number("body", "", body(0), "number or name"), number("and body", "", body(1), "number or name"),
      element("h2", {}, "Contacts found by"),
      ...FOUND.filter((_, k) => used.has(k)).map((name) =>
        box(name, true, (on) => { on ? this.found.add(name) : this.found.delete(name); })),
      element("h2", {}, "Contacts with"),
      number("depth at least", "0", (text) => { this.least = Number(text) || 0; }),
      number("age at least [steps]", "0", (text) => { this.ages[0] = Number(text) || 0; }),
      number("age at most [steps]", "", (text) => { this.ages[1] = text === "" ? Infinity : Number(text); }, "any"),
      element("p", { id: "shown-count", class: "faint" }));
  }

  /** The number of a body by number or name; -1 if there is none. */
  bodyNamed(text) {
    if (/^\d+$/.test(text) && Number(text) < this.data.bodies.length) return Number(text);
    return this.data.bodies.findIndex((body) => body.name.toLowerCase() === text.toLowerCase());
  }

  /** Whether the contact at a place of the columns is shown. */
  keeps(i) {
    const c = this.data.columns, a = c.contact_a[i], b = c.contact_b[i], [one, other] = this.bodies;
    if (!this.found.has(FOUND[c.contact_found[i]])) return false;
    if (!(c.contact_edge_end[i] > 0 ? this.edges : this.vertices)) return false;
    if (one !== undefined && a !== one && b !== one) return false;
    if (other !== undefined && a !== other && b !== other) return false;
    if (this.least > 0 && -c.contact_distance[i] < this.least) return false;
    return c.contact_age[i] >= this.ages[0] && c.contact_age[i] <= this.ages[1];
  }
}
