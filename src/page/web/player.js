"use strict";
// Plays the frames and keeps everything at the same frame and selection.

const KEYS = [
  ["space", "play or pause"], ["← →", "one frame back or on; with shift, ten"], ["Home End", "first or last frame"],
  ["n p", "next or last contact"], ["c", "look at what is selected"], ["a", "look at everything"],
  ["r", "rays"], ["b", "boxes"], ["g", "patches"], ["x", "contacts in front of bodies, or inside"], ["f", "search"],
  ["t", "light or dark"], ["Esc", "select nothing"], ["?", "these keys"],
];
const FRAMES_PER_SECOND = 30;  // of pages that do not know the time
const PATIENCE = 200;          // [ms] numbers that change faster cannot be read
const USUAL_SHARE = 0.95;
const ARROW_SHARE = 0.3;        // the longest arrow, of a usual body
const NEAR_ARROW_SHARE = 0.03;  // the same where nothing is deep, and all arrows are much the same
const byId = (id) => document.getElementById(id);

class Player {
  constructor(data) {
    this.data = data;
    this.frame = -1;
    this.told = 0;  // when details were last shown
    this.selection = {};
    this.stage = new Stage(byId("canvas"), data);
    this.deepest = this.#usualDepth();
    const unit = this.#usualSize();
    const longest = this.deepest || data.columns.contact_distance.reduce((most, d) => Math.max(most, Math.abs(d)), 0);
    this.arrowUnit = longest > 0 ? ((this.deepest > 0 ? ARROW_SHARE : NEAR_ARROW_SHARE) * unit) / longest : 1;
    this.bodies = new Bodies(data, this.stage.scene);
    this.contacts = new Contacts(data, this.stage.scene, unit);
    this.contacts.inFront = true;
    this.contacts.arrowScale = this.arrowUnit;
    this.overlays = new Overlays(data, this.stage.scene);
    this.details = new Details(data, byId("details"), this);
    this.charts = new Charts(data, byId("charts"), (frame) => this.go(frame));
    this.filters = new Filters(data, byId("show"), () => this.refresh());
    this.#buildControls();
    this.#listen();
    drawLegend(byId("legend-colors"));
    byId("legend").hidden = this.deepest === 0;
    byId("legend-high").textContent = `${Number(this.deepest.toPrecision(2))} deep or more`;
    showAbout(data, byId("about"));
    this.readHash();
    if (this.frame < 0) this.go(0);
  }

  /** Nearly all contacts are less deep; the colours of the rest are the last one. */
  #usualDepth() {
    const depths = Float64Array.from(this.data.columns.contact_distance, (d) => Math.max(-d, 0)).sort();
    return depths.length ? depths[Math.floor(USUAL_SHARE * (depths.length - 1))] : 0;
  }

  /** The size of the body in the middle, of all that move. */
  #usualSize() {
    const sizes = this.data.bodies.flatMap((body, b) => {
      if (body.motion === "fixed" || !this.data.meshOf(0, b)) return [];
      const [lower, upper] = boxAround(this.data.verticesAt(0, b));
      return [size(minus(upper, lower))];
    }).filter(Number.isFinite).sort((a, b) => a - b);
    return sizes.length ? sizes[sizes.length >> 1] : this.stage.radius;
  }

  #buildControls() {
    const { contacts, overlays, bodies } = this;
    this.filters.build([
      ["points", true, (on) => { contacts.showPoints = on; }],
      ["arrows along normals, as long as contacts are deep", true, (on) => { contacts.showArrows = on; }],
      ["contacts in front of bodies", true, (on) => { contacts.inFront = on; }],
      ["rays, from a contact's point to where it ends", false, (on) => { contacts.showRays = on; }],
      ["boxes around bodies", false, (on) => { overlays.showBoxes = on; }],
      ["patches of vertices, of the selected body or of all", false, (on) => { overlays.showPatches = on; }],
      ...(this.data.bodies.some((body) => body.sheet) ? [["where sheets were one frame before", false, (on) => { bodies.showGhosts = on; }]] : []),
    ], (opacity) => { bodies.opacity = opacity; }, (scale) => { contacts.arrowScale = scale * this.arrowUnit; });
    const slider = byId("slider");
    slider.max = this.data.frameCount - 1;
    slider.addEventListener("input", () => this.go(Number(slider.value)));
    byId("key-table").append(...KEYS.map(([key, what]) => element("tr", {}, element("th", {}, key), element("td", {}, what))));
    const on = (id, act) => byId(id).addEventListener("click", act);
    on("first", () => this.go(0));
    on("back", () => this.step(-1));
    on("forward", () => this.step(1));
    on("play", () => this.toggle());
    on("theme", () => this.#switchTheme());
    on("help", () => byId("keys").showModal());
    for (const tab of document.querySelectorAll("#tabs button")) tab.addEventListener("click", () => this.showTab(tab.dataset.tab));
    byId("search").addEventListener("submit", (event) => { event.preventDefault(); this.search(byId("search-text").value); });
  }

  #listen() {
    this.stage.listen((x, y) => this.click(x, y));
    window.addEventListener("hashchange", () => this.readHash());
    window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.#themeChanged());
    document.addEventListener("keydown", (event) => {
      if (event.target.matches("input[type=text], input[type=search], select") || event.ctrlKey || event.metaKey || event.altKey) return;
      const step = event.shiftKey ? 10 : 1;
      const acts = {
        " ": () => this.toggle(), ArrowLeft: () => this.step(-step), ArrowRight: () => this.step(step), Home: () => this.go(0),
        End: () => this.go(this.data.frameCount - 1), n: () => this.nextContact(1), p: () => this.nextContact(-1),
        c: () => this.lookAtSelection(), a: () => { this.stage.frameAll(); this.stage.draw(); }, r: () => this.#switchBox("rays"),
        b: () => this.#switchBox("boxes"), g: () => this.#switchBox("patches"), x: () => this.#switchBox("contacts in front"),
        f: () => byId("search-text").focus(), t: () => this.#switchTheme(), Escape: () => this.select({}), "?": () => byId("keys").showModal(),
      };
      if (!acts[event.key]) return;
      event.preventDefault();
      acts[event.key]();
    });
  }

  #switchBox(begin) {
    for (const label of byId("show").querySelectorAll("label"))
      if (label.textContent.trim().startsWith(begin)) label.querySelector("input").click();
  }

  #switchTheme() {
    const root = document.documentElement, dark = getComputedStyle(root).getPropertyValue("--back").trim() !== "#ffffff";
    root.dataset.theme = dark ? "light" : "dark";
    this.#themeChanged();
  }
  #themeChanged() {
    this.charts.redraw();
    this.stage.draw();
  }

  showTab(name) {
    for (const tab of document.querySelectorAll("#tabs button")) tab.classList.toggle("on", tab.dataset.tab === name);
    for (const panel of document.querySelectorAll(".tab")) panel.classList.toggle("on", panel.id === name);
    if (name === "charts") this.charts.draw();
  }

  go(frame) {
    frame = Math.min(Math.max(frame, 0), this.data.frameCount - 1);
    if (frame === this.frame) return;
    this.#followContact(frame);
    this.frame = frame;
    this.refresh();
  }
  step(count) {
    this.pause();
    this.go(this.frame + count);
  }

  /** Keeps the selected contact selected where the next frame has it, too. */
  #followContact(frame) {
    if (this.selection.contact === undefined || this.frame < 0) return;
    const c = this.data.columns, from = c.contact_begin[this.frame] + this.selection.contact;
    const names = ["contact_a", "contact_b", "contact_vertex", "contact_edge_end"];
    const is = (i) => names.every((name) => c[name][i] === c[name][from]) && (c.contact_flags[i] & 1) === (c.contact_flags[from] & 1);
    const [begin, end] = this.data.contactRange(frame);
    let found = begin;
    while (found < end && !is(found)) ++found;
    if (found < end) this.selection = { contact: found - begin };
    else this.selection = { body: c.contact_flags[from] & 1 ? c.contact_b[from] : c.contact_a[from], vertex: c.contact_vertex[from] };
  }

  /** Draws the frame and the selection as they are now. */
  refresh() {
    const { data, frame, filters, selection } = this;
    const depths = this.#depths(frame);
    // Where nothing is deep, such as between sheets, colours tell how contacts were found.
    const { contact_distance: distance, contact_found: found } = data.columns;
    const ofContact = (i) => this.deepest > 0 ? cividis(-distance[i] / this.deepest) : channels(KINDS[found[i] % KINDS.length]);
    this.bodies.show(frame, (b) => {
      if (b === selection.body) return SELECTED_BODY;
      if (filters.colors === "body") return channels(KINDS[b % KINDS.length]);
      const colored = filters.colors === "depth" && depths[b] >= 0 && data.bodies[b].motion !== "fixed";
      return colored ? bodyColor(this.deepest > 0 ? depths[b] / this.deepest : 0) : PLAIN;
    });
    this.contacts.show(frame, (i) => filters.keeps(i), ofContact, selection.contact);
    this.overlays.show(frame, this.#selectedBody(), selection.vertex);
    const now = performance.now();
    if (!this.playing || now - this.told > PATIENCE) {
      this.details.show(frame, selection);
      this.told = now;
    }
    this.charts.show(frame);
    this.stage.draw();
    const [begin, end] = data.contactRange(frame);
    byId("shown-count").textContent = `${this.contacts.shown.length} of ${end - begin} contacts are shown.`;
    byId("slider").value = frame;
    byId("frame").textContent = `${frame} / ${data.frameCount - 1}` + (data.dt > 0 ? `, ${(frame * data.dt).toFixed(2)} s` : "");
    if (!this.playing) this.#writeHash();
  }

  /** The deepest contact of every body; negative for a body without one. */
  #depths(frame) {
    const c = this.data.columns, depths = new Float64Array(this.data.bodies.length).fill(-1);
    const [begin, end] = this.data.contactRange(frame);
    for (let i = begin; i < end; ++i)
      for (const body of [c.contact_a[i], c.contact_b[i]]) depths[body] = Math.max(depths[body], -c.contact_distance[i], 0);
    return depths;
  }
  #selectedBody() {
    const { contact, body } = this.selection;
    if (contact === undefined) return body;
    const c = this.data.columns, i = c.contact_begin[this.frame] + contact;
    return c.contact_flags[i] & 1 ? c.contact_b[i] : c.contact_a[i];
  }

  select(selection) {
    this.selection = selection;
    this.showTab("details");
    this.refresh();
  }
  click(x, y) {
    const contact = this.stage.contactAt(this.contacts, x, y);
    if (contact !== undefined) return this.select({ contact });
    const hit = this.bodies.pick(this.frame, ...this.stage.sight(x, y));
    this.select(hit ? { body: hit.body, vertex: hit.vertex } : {});
  }
  nextContact(way) {
    const shown = this.contacts.shown.map(({ number }) => number), at = shown.indexOf(this.selection.contact);
    if (shown.length) this.select({ contact: shown[(at < 0 && way < 0 ? shown.length - 1 : at + way + shown.length) % shown.length] });
  }
  lookAtSelection() {
    const { contact, body, vertex } = this.selection, { data, frame } = this;
    const at = contact !== undefined ? data.contact(frame, contact).point_a
      : vertex !== undefined ? data.hasVertex(frame, body, vertex) && data.vertexAt(frame, body, vertex)
      : body !== undefined && data.meshOf(frame, body) ? mix(...boxAround(data.verticesAt(frame, body)), 0.5) : null;
    if (at) this.stage.lookAt(at, 0.5 * this.stage.radius);
    this.stage.draw();
  }

  /** "c88", "b3", "v3:7" (body and vertex), or a body's name. */
  search(text) {
    const asked = text.trim(), match = /^([cbv])\s*(\d+)(?:[:\s]+(\d+))?$/i.exec(asked);
    const found = match ? this.#selectionOf(match[1].toLowerCase(), Number(match[2]), match[3]) : this.#bodyLike(asked);
    byId("message").textContent = found ? "" : `There is no "${asked}" in frame ${this.frame}.`;
    if (found) this.select(found);
  }
  #bodyLike(text) {
    let body = this.filters.bodyNamed(text);
    if (body < 0) body = this.data.bodies.findIndex(({ name }) => text && name.toLowerCase().includes(text.toLowerCase()));
    return body < 0 ? null : { body };
  }
  /** A selection that exists in this frame, or null. */
  #selectionOf(kind, number, vertex) {
    const [begin, end] = this.data.contactRange(this.frame);
    if (kind === "c") return number < end - begin ? { contact: number } : null;
    const mesh = number < this.data.bodies.length && this.data.meshOf(this.frame, number);
    if (!mesh) return null;
    if (kind === "b") return { body: number };
    return vertex !== undefined && Number(vertex) < mesh.vertices.length / 3 ? { body: number, vertex: Number(vertex) } : null;
  }

  /** Frame and selection as they are in the page's address: "#f=12&c=88", "&b=3", or "&v=3:7". */
  readHash() {
    const asked = new URLSearchParams(location.hash.slice(1));
    if (location.hash.slice(1) === this.hash) return;
    this.selection = {};
    if (/^\d+$/.test(asked.get("f") ?? "")) this.go(Number(asked.get("f")));
    if (this.frame < 0) this.go(0);
    for (const kind of ["c", "b", "v"]) {
      const match = /^(\d+)(?::(\d+))?$/.exec(asked.get(kind) ?? "");
      const found = match && this.#selectionOf(kind, Number(match[1]), match[2]);
      if (found) this.select(found);
    }
  }
  #writeHash() {
    const { contact, body, vertex } = this.selection;
    this.hash = `f=${this.frame}` + (contact !== undefined ? `&c=${contact}` : vertex !== undefined ? `&v=${body}:${vertex}` : body !== undefined ? `&b=${body}` : "");
    history.replaceState(null, "", `#${this.hash}`);
  }

  toggle() { this.playing ? this.pause() : this.play(); }
  pause() {
    if (!this.playing) return;
    this.playing = this.bodies.coarse = false;
    byId("play").textContent = "▶";
    this.refresh();
  }
  play() {
    if (this.data.frameCount < 2) return;
    this.playing = true;
    this.bodies.coarse = this.stage.bySoftware;
    byId("play").textContent = "⏸";
    if (this.frame === this.data.frameCount - 1) this.go(0);
    let last = performance.now(), due = 0;
    const tick = (now) => {
      if (!this.playing) return;
      const rate = (this.data.dt > 0 ? 1 / this.data.dt : FRAMES_PER_SECOND) * Number(byId("speed").value);
      due += ((now - last) / 1000) * rate;
      last = now;
      const frames = Math.floor(due);
      due -= frames;
      if (frames > 0) this.go(this.frame + frames);
      if (this.frame === this.data.frameCount - 1) this.pause();
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }
}

(async () => {
  try {
    window.player = new Player(await SceneData.read(byId("data").textContent));
    byId("title").textContent = window.player.data.title;
    byId("data").remove();
    byId("message").textContent = "";
    document.body.dataset.ready = "true";
  } catch (error) {
    byId("message").textContent = `This page cannot be shown: ${error.message}`;
    console.error(error);
  }
})();
