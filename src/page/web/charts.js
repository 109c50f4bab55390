"use strict";
// Charts of a frame's figures over the frames; a click goes to that frame.

/** Charts, and the words that begin the names of their series; what no other one takes is a count. */
const CHART_TITLES = { ms: "Time [ms]", depth: "Depth [length]", error: "Error", counts: "Counts" };
const MOST_SERIES = KINDS.length;

const isNumber = (value) => typeof value === "number";

/** Series by chart: {chart: {name: [number per frame]}}; what is zero in all frames is left out. */
function seriesOf(figures) {
  const charts = {};
  const put = (chart, name, frame, value) => {
    charts[chart] ??= {};
    charts[chart][name] ??= new Array(figures.length).fill(null);
    charts[chart][name][frame] = value;
  };
  figures.forEach((frame, f) => {
    for (const [name, value] of Object.entries(frame)) {
      if (value && typeof value === "object" && !Array.isArray(value)) {
        for (const [part, number] of Object.entries(value)) if (isNumber(number)) put(name, part, f, number);
      } else if (isNumber(value) && name !== "index" && name !== "status") {
        put(/penetration|depth/.test(name) ? "depth" : "counts", name, f, value);
      }
    }
  });
  for (const [chart, series] of Object.entries(charts)) {
    for (const [name, values] of Object.entries(series)) if (!values.some((v) => v)) delete series[name];
    if (!Object.keys(series).length) delete charts[chart];
  }
  return charts;
}

class Charts {
  constructor(data, place, goTo) {
    this.data = data;
    this.place = place;
    this.goTo = goTo;
    this.charts = [];
  }

  /** Draws all charts, once; Chart.js needs them to be visible. */
  draw() {
    if (this.charts.length) return;
    const charts = seriesOf(this.data.figures);
    if (!Object.keys(charts).length) this.place.textContent = "This page has no figures of frames.";
    for (const [chart, series] of Object.entries(charts)) this.#add(CHART_TITLES[chart] ?? chart, series);
  }

  #add(title, series) {
    const box = element("div", { class: "chart" });
    const canvas = element("canvas"), cursor = element("div", { class: "cursor" });
    box.append(canvas, cursor);
    this.place.append(element("h2", {}, title), box);
    const largest = (values) => Math.max(...values.filter(isNumber));
    const names = Object.keys(series).sort((a, b) => largest(series[b]) - largest(series[a]));
    const ink = themed("--faint"), line = themed("--line");
    const chart = new Chart(canvas, {
      type: "line",
      data: {
        labels: this.data.figures.map((_, f) => f),
        datasets: names.map((name, k) => ({
          label: name.replaceAll("_", " "), data: series[name], hidden: k >= MOST_SERIES,
          borderColor: KINDS[k % MOST_SERIES], backgroundColor: KINDS[k % MOST_SERIES],
          borderDash: k >= MOST_SERIES ? [4, 3] : [], borderWidth: 1.4, pointRadius: series[name].filter(isNumber).length > 1 ? 0 : 4,
          spanGaps: true,  // errors are known where the truth is, which may be every fourth frame
        })),
      },
      options: {
        animation: false, maintainAspectRatio: false, normalized: true,
        interaction: { mode: "index", intersect: false },
        onClick: (event) => {
          const frame = Math.round(chart.scales.x.getValueForPixel(event.x));
          this.goTo(Math.min(Math.max(frame, 0), this.data.frameCount - 1));
        },
        scales: {
          x: { title: { display: true, text: "frame", color: ink }, ticks: { color: ink, maxTicksLimit: 7, maxRotation: 0 }, grid: { color: line } },
          y: { beginAtZero: true, ticks: { color: ink, maxTicksLimit: 6 }, grid: { color: line } },
        },
        plugins: { legend: { position: "bottom", labels: { color: ink, boxWidth: 14, boxHeight: 2, padding: 6, font: { size: 11 } } } },
      },
      // A chart is laid out again when its place changes, as by a scrollbar that later charts bring.
      plugins: [{ id: "cursor", afterLayout: (chart) => this.#put(cursor, chart) }],
    });
    this.charts.push({ chart, cursor });
  }

  /** Puts a chart's cursor at the frame. */
  #put(cursor, chart) {
    const { top, bottom } = chart.chartArea;
    cursor.style.left = `${chart.scales.x.getPixelForValue(this.frame ?? 0)}px`;
    cursor.style.top = `${top}px`;
    cursor.style.height = `${bottom - top}px`;
  }

  /** Colours follow the theme. */
  redraw() {
    if (!this.charts.length) return;
    for (const { chart } of this.charts) chart.destroy();
    this.charts = [];
    this.place.replaceChildren();
    this.draw();
  }

  /** Puts the cursors at a frame. */
  show(frame) {
    this.frame = frame;
    for (const { chart, cursor } of this.charts) this.#put(cursor, chart);
  }
}
