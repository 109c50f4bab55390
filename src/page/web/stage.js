"use strict";
// The camera, the renderer, and what is under the pointer.

const CLICK_PIXELS = 9;  // a contact is hit this far away
const DRAG_PIXELS = 4;   // further is a drag, not a click

/** True if there is no GPU: smooth edges would take too long. */
function drawsBySoftware() {
  const gl = document.createElement("canvas").getContext("webgl");
  const names = gl?.getExtension("WEBGL_debug_renderer_info");
  return names !== null && names !== undefined && /swiftshader|llvmpipe|software/i.test(gl.getParameter(names.UNMASKED_RENDERER_WEBGL));
}

class Stage {
  constructor(canvas, data) {
    this.canvas = canvas;
    this.data = data;
    this.bySoftware = drawsBySoftware();
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: !this.bySoftware });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(40, 1, 0.1, 1000);
    this.camera.up.set(0, 0, 1);
    this.controls = new THREE.OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.draw());
    this.frameAll();
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
    this.resize();
  }

  /** Looks at where everything that moves is in the end; if nothing moves, at everything. */
  frameAll() {
    const last = this.data.frameCount - 1;
    const boxes = (moving) => this.data.bodies.flatMap((body, b) => {
      if (!this.data.meshOf(last, b) || (moving && body.motion === "fixed")) return [];
      const box = boxAround(this.data.verticesAt(last, b));
      return box.flat().every(Number.isFinite) ? [box] : [];
    });
    const all = boxes(true).length ? boxes(true) : boxes(false);
    const [lower, upper] = boxAround(all.flat(2));
    this.center = all.length ? mix(lower, upper, 0.5) : [0, 0, 0];
    this.radius = all.length ? Math.max(size(minus(upper, lower)) / 2, 1e-9) : 1;
    this.lookAt(this.center, 2.1 * this.radius);
  }

  lookAt(point, distance) {
    const from = add(point, scaled([0.5, -0.75, 0.43], distance));
    this.camera.near = distance / 500;
    this.camera.far = 40 * this.radius + 10 * distance;
    this.camera.position.set(...from);
    this.camera.updateProjectionMatrix();
    this.controls.target.set(...point);
    this.controls.update();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!width || !height) return;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  draw() {
    this.renderer.setClearColor(themed("--scene"));
    this.renderer.render(this.scene, this.camera);
  }

  /** Pixels of the canvas where a point is seen; null behind the camera. */
  pixelsOf(point) {
    const p = new THREE.Vector3(...point).project(this.camera);
    if (p.z > 1) return null;
    return [(p.x + 1) / 2 * this.canvas.clientWidth, (1 - p.y) / 2 * this.canvas.clientHeight];
  }

  /** Calls `onClick` with pixels of the canvas. */
  listen(onClick) {
    let down = null;
    this.canvas.addEventListener("pointerdown", (event) => { down = [event.clientX, event.clientY]; });
    this.canvas.addEventListener("pointerup", (event) => {
      if (!down || Math.hypot(event.clientX - down[0], event.clientY - down[1]) > DRAG_PIXELS) return;
      const box = this.canvas.getBoundingClientRect();
      onClick(event.clientX - box.left, event.clientY - box.top);
    });
  }

  /** The number of the contact that is seen at a pixel; undefined if there is none. */
  contactAt(contacts, x, y) {
    let best, nearest = CLICK_PIXELS;
    for (const { number, at } of contacts.shown) {
      const seen = this.pixelsOf(at);
      const away = seen ? Math.hypot(seen[0] - x, seen[1] - y) : Infinity;
      if (away < nearest) [best, nearest] = [number, away];
    }
    return best;
  }

  /** Origin and direction of the line of sight through a pixel. */
  sight(x, y) {
    const far = new THREE.Vector3(2 * x / this.canvas.clientWidth - 1, 1 - 2 * y / this.canvas.clientHeight, 0.5);
    far.unproject(this.camera);
    const origin = this.camera.position.toArray(), way = minus(far.toArray(), origin);
    return [origin, scaled(way, 1 / size(way))];
  }
}
