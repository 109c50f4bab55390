"use strict";
// Colours that the colour-blind can tell apart: cividis for numbers, Okabe and Ito's for kinds.

/** cividis at equal distances, each channel from 0 to 1. */
const CIVIDIS = [[0, 34, 78], [53, 69, 108], [102, 105, 112], [148, 142, 119], [200, 184, 102], [254, 232, 56]]
  .map((color) => color.map((channel) => channel / 255));
const KINDS = ["#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#8f7a00", "#7f7f7f"];
const PLAIN = [0.72, 0.74, 0.76];
const SELECTED = [0.84, 0.37, 0];
const SELECTED_BODY = [0.93, 0.64, 0.42];

/** The colour of a share from 0 to 1. */
function cividis(share) {
  const at = Math.min(Math.max(share, 0), 1) * (CIVIDIS.length - 1), low = Math.min(Math.floor(at), CIVIDIS.length - 2);
  return mix(CIVIDIS[low], CIVIDIS[low + 1], at - low);
}

/** The colour of a body with a contact of that share: lighter, so that contacts stand out. */
const bodyColor = (share) => mix(PLAIN, cividis(share), 0.5);

/** Channels from 0 to 1 of "#rrggbb". */
const channels = (text) => [1, 3, 5].map((k) => parseInt(text.slice(k, k + 2), 16) / 255);

/** A value of the style sheet. */
const themed = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

function drawLegend(canvas) {
  const context = canvas.getContext("2d");
  for (let x = 0; x < canvas.width; ++x) {
    const [r, g, b] = cividis(x / canvas.width).map((channel) => Math.round(255 * channel));
    context.fillStyle = `rgb(${r},${g},${b})`;
    context.fillRect(x, 0, 1, canvas.height);
  }
}
