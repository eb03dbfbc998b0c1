// scene.js - bodies, light, floor and camera. Draws when asked to, not all the time.
import {
  ACESFilmicToneMapping, BackSide, BoxGeometry, BufferAttribute, BufferGeometry, CapsuleGeometry, CircleGeometry, Color, ConeGeometry, CylinderGeometry,
  DirectionalLight, Fog, Group, HemisphereLight, Matrix4, Mesh, PCFShadowMap, PerspectiveCamera, PointLight, Raycaster, Scene as ThreeScene, ShaderMaterial, SphereGeometry, Vector2, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { RoundedBoxGeometry } from "three/addons/geometries/RoundedBoxGeometry.js";
import { bodyMaterial } from "./materials.js";
import { reflectionsOf } from "./reflections.js";
import { digColour, heatColour } from "./format.js";

const SKIES = {
  light: { top: 0x9db7d6, rim: 0xdfe3e8, low: 0xa9a6a0, sun: 2.6, fill: 0.55, mirror: 0.55 },
  dark: { top: 0x232c3d, rim: 0x566173, low: 0x262a33, sun: 2.6, fill: 0.7, mirror: 0.8 },
};

// Of the script's skies those that are not the page's own, by its theme.
const SCRIPT_SKIES = {
  overcast: { top: 0xaeb4ba, rim: 0xd2d5d8, low: 0x9a9894, sun: 1.1, fill: 1.3, mirror: 0.5 },
  night: { top: 0x0f1626, rim: 0x232c3e, low: 0x1a1d26, sun: 0.35, fill: 0.3, mirror: 0.5 },
  black: { top: 0x000000, rim: 0x000000, low: 0x000000, sun: 2.6, fill: 0.25, mirror: 0.2 },
};
const LAMP = 1 / 16;        // cd per W: a white surface that pictures draw with 0.25 per W/m^2 (engine/render/paint.c) is as bright here

const SKY_VERTEX = "varying vec3 ray; void main() { ray = position; gl_Position = projectionMatrix * vec4(mat3(viewMatrix) * position, 1.0); gl_Position.z = gl_Position.w; }";
const SKY_FRAGMENT = /* glsl */ `
  varying vec3 ray; uniform vec3 up, top, rim;
  void main() {
    float h = dot(normalize(ray), up), away = 1.0 - clamp(h * 1.3, 0.0, 1.0);
    gl_FragColor = vec4(mix(top, rim, away * away * away), 1.0);
    #include <colorspace_fragment>
  }`;

function skyMaterial(up) {
  return new ShaderMaterial({
    vertexShader: SKY_VERTEX, fragmentShader: SKY_FRAGMENT, side: BackSide, depthWrite: false,
    uniforms: { up: { value: up }, top: { value: new Color() }, rim: { value: new Color() } },
  });
}

// 1, 2 or 5 times a power of ten metres, about a twelfth of the scene.
function tileSize(size) {
  const want = 0.08 * size, power = 10 ** Math.floor(Math.log10(want)), step = want / power;
  return (step < 1.5 ? 1 : step < 3.5 ? 2 : step < 7.5 ? 5 : 10) * power;
}

export class Scene {
  constructor(canvas, replay, changed) {
    this.replay = replay;
    this.canvas = canvas;
    this.changed = changed;
    this.renderer = new WebGLRenderer({ canvas, antialias: true, powerPreference: "high-performance" });
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = PCFShadowMap;
    this.renderer.toneMapping = ACESFilmicToneMapping;
    this.renderer.toneMappingExposure = 0.95;
    this.renderer.debug.checkShaderErrors = false;      // asking waits for the compiler
    this.scene = new ThreeScene();
    this.up = new Vector3(...replay.up).normalize();
    this.measure();
    this.camera = new PerspectiveCamera(40, 1, this.size * 1e-3, this.size * 400);
    this.camera.up.copy(this.up);
    this.makeLight();
    this.makeBodies();
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.zoomToCursor = true;
    this.controls.maxDistance = this.size * 40;
    this.controls.minDistance = this.size * 5e-3;
    this.controls.addEventListener("change", changed);
    this.controls.addEventListener("start", () => this.released());
    this.released = () => {};           // somebody turns the view
    this.follows = -1;                  // number of the script's camera that is shown; -1: none
    this.lookAtAll();
    this.picked = -1;
    this.colouring = "own";
  }

  // Bounds of where the bodies are at the start and on their way, without what flies far off.
  measure() {
    const low = new Vector3(...this.replay.low), high = new Vector3(...this.replay.high);
    if (!(low.x <= high.x)) { low.set(-1, -1, -1); high.set(1, 1, 1); }
    this.middle = low.clone().add(high).multiplyScalar(0.5);
    this.size = Math.max(1e-4, low.distanceTo(high));
    this.low = low;
    this.high = high;
  }

  makeLight() {
    this.hemisphere = new HemisphereLight(0xffffff, 0x888888, 0.6);
    this.hemisphere.position.copy(this.up);
    this.sun = new DirectionalLight(0xfff3e2, 3);
    const side = this.sideways();
    this.sun.position.copy(this.middle).addScaledVector(this.up, 2 * this.size).addScaledVector(side[0], 0.9 * this.size).addScaledVector(side[1], 0.7 * this.size);
    this.sun.target.position.copy(this.middle);
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(2048, 2048);
    this.sun.shadow.radius = 2.5;
    const c = this.sun.shadow.camera, r = 0.75 * this.size;
    Object.assign(c, { left: -r, right: r, top: r, bottom: -r, near: 0.2 * this.size, far: 5 * this.size });
    this.sun.shadow.normalBias = 0.003 * this.size;
    this.sun.shadow.bias = -0.0004;
    this.sky = new Mesh(new SphereGeometry(1, 32, 16), skyMaterial(this.up));
    this.sky.frustumCulled = false;
    this.sky.renderOrder = -10;
    this.scene.add(this.hemisphere, this.sun, this.sun.target, this.sky);
  }

  // Two horizontal directions, the first one "to the right" of the first camera.
  sideways() {
    const seed = Math.abs(this.up.x) > 0.9 ? new Vector3(0, 1, 0) : new Vector3(1, 0, 0);
    const right = seed.addScaledVector(this.up, -seed.dot(this.up)).normalize();
    return [right, new Vector3().crossVectors(right, this.up).normalize()];
  }

  // Sun, shadows, sky and lamps as the script has them.
  setLight(light) {
    this.lit = light;
    for (const lamp of this.lamps ?? []) this.scene.remove(lamp);
    this.lamps = (light?.lamps ?? []).map(({ at, power, colour }) => {
      const lamp = new PointLight(new Color().setRGB(...colour), LAMP * power);
      lamp.position.set(...at);
      this.scene.add(lamp);
      return lamp;
    });
    if (!light) return;
    const sun = new Vector3(...light.sun);
    this.sun.visible = sun.length() > 0;
    if (this.sun.visible) this.sun.position.copy(this.middle).addScaledVector(sun.normalize(), 2.3 * this.size);
    this.sun.castShadow = light.shadows;
    if (this.dark !== undefined) this.setTheme(this.dark);
  }

  setTheme(dark) {
    const sky = SCRIPT_SKIES[this.lit?.sky] ?? SKIES[dark ? "dark" : "light"];
    this.dark = dark;
    const { uniforms } = this.sky.material;
    uniforms.top.value.set(sky.top);
    uniforms.rim.value.set(sky.rim);
    this.scene.fog = new Fog(sky.rim, 3 * this.size, 22 * this.size);
    this.sun.intensity = sky.sun;
    this.hemisphere.intensity = sky.fill;
    this.hemisphere.color.set(sky.top).lerp(new Color(0xffffff), 0.55);
    this.hemisphere.groundColor.set(sky.low);
    this.makeReflections(sky);
    this.changed();
  }

  makeReflections(sky) {
    if (this.mirrored === sky) return;
    this.mirrored = sky;
    const colours = Object.fromEntries(["top", "rim", "low"].map((part) => [part, new Color(sky[part])]));
    this.reflections?.dispose();
    this.reflections = reflectionsOf(colours, this.up);
    this.scene.environment = this.reflections;
    this.scene.environmentIntensity = sky.mirror;
  }

  geometry(index) {
    const m = this.replay.meshes[index], [a, b, c] = m.size;
    switch (m.form) {
      case "sphere": return { geometry: new SphereGeometry(a, 40, 24), half: [a, a, a] };
      case "box": {
        const bevel = 0.045 * Math.min(a, b, c);
        return { geometry: Math.max(a, b, c) < 60 * Math.min(a, b, c) ? new RoundedBoxGeometry(a, b, c, 2, bevel) : new BoxGeometry(a, b, c), half: [a / 2, b / 2, c / 2] };
      }
      case "capsule": return { geometry: new CapsuleGeometry(a, b, 10, 28), half: [a, a + b / 2, a] };
      case "cylinder": return { geometry: new CylinderGeometry(a, a, b, 40), half: [a, b / 2, a] };
      case "cone": return { geometry: this.meshGeometry(m) ?? new ConeGeometry(a, b, 40), half: [a, b / 2, a] };
      default: break;
    }
    const geometry = this.meshGeometry(m);
    geometry.computeBoundingBox();
    const box = geometry.boundingBox;
    const half = ["x", "y", "z"].map((k) => Math.max(1e-9, Math.abs(box.min[k]), Math.abs(box.max[k])));
    return { geometry, half };
  }

  meshGeometry(m) {
    if (!m.vertices[1]) return null;
    let geometry = new BufferGeometry();
    const part = (name, [first, count]) => this.replay[name].slice(first, first + count);
    geometry.setAttribute("position", new BufferAttribute(part("vertex", m.vertices), 3));
    geometry.setIndex(new BufferAttribute(part("index", m.indices), 1));
    if (m.normals) {
      geometry.setAttribute("normal", new BufferAttribute(part("normal", m.normals), 3));
    } else {
      geometry = geometry.toNonIndexed();
      geometry.computeVertexNormals();
    }
    return geometry;
  }

  makeBodies() {
    const made = this.replay.meshes.map(() => null);
    this.groups = this.replay.bodies.map((_, i) => {
      const group = new Group();
      group.userData.body = i;
      this.scene.add(group);
      return group;
    });
    this.planes = [];
    for (const shape of this.replay.shapes) {
      const form = this.replay.meshes[shape.mesh].form;
      const mesh = form === "plane" ? this.planeMesh(shape) : this.shapeMesh(shape, form, made);
      mesh.position.set(...shape.p);
      mesh.quaternion.set(...shape.q);
      mesh.userData.body = shape.body;
      (shape.body < 0 ? this.scene : this.groups[shape.body]).add(mesh);
    }
  }

  shapeMesh(shape, form, made) {
    made[shape.mesh] ??= this.geometry(shape.mesh);
    const { geometry, half } = made[shape.mesh];
    const mesh = new Mesh(geometry, bodyMaterial(shape, form, half, (0.6180339887 * (shape.body + 1)) % 1, 0));
    mesh.castShadow = mesh.receiveShadow = true;
    return mesh;
  }

  planeMesh(shape) {
    const geometry = new CircleGeometry(60 * this.size, 64).applyMatrix4(new Matrix4().makeRotationX(-Math.PI / 2));
    const mesh = new Mesh(geometry, bodyMaterial(shape, "plane", [1, 1, 1], 0, tileSize(this.size)));
    mesh.receiveShadow = true;
    mesh.userData.plane = true;
    this.planes.push(mesh);
    return mesh;
  }

  awayFromAll() {
    const [right, front] = this.sideways();
    return right.clone().multiplyScalar(0.55).addScaledVector(front, 1).addScaledVector(this.up, 0.38).normalize();
  }

  lookAtAll() {
    this.look(this.middle, this.awayFromAll(), this.size * 0.5);
  }

  // m, from which a ball fills the picture
  distanceFor(radius) {
    const half = (this.camera.fov * Math.PI) / 360, narrow = Math.min(1, this.camera.aspect || 1);
    return (0.92 * radius) / Math.sin(half) / narrow;
  }

  // Where the script's camera stands; what it does not say is as in the view of all.
  follow(frame, part) {
    const r = this.replay, now = r.cameraAt(this.follows, frame);
    if (!now) return;
    const next = part > 0 ? r.cameraAt(this.follows, frame + 1) ?? now : now;
    const between = (name) => (now[name] && next[name] ? new Vector3(...now[name]).lerp(new Vector3(...next[name]), part) : now[name] && new Vector3(...now[name]));
    const at = between("at"), target = between("look_at") ?? this.middle.clone(), angle = (180 / Math.PI) * now.fov;
    this.camera.up.copy(between("up") ?? this.up);
    if (this.camera.fov !== angle) {
      this.camera.fov = angle;
      this.camera.updateProjectionMatrix();
    }
    if (at) {
      this.camera.position.copy(at);
    } else {
      const away = this.awayFromAll();
      this.camera.position.copy(target).addScaledVector(away, this.distanceFor(0.5 * this.size));
    }
    this.controls.target.copy(target);
    this.camera.lookAt(target);
  }

  // The view is somebody's own again; it stays where it is.
  free() {
    this.follows = -1;
    this.camera.up.copy(this.up);
    this.controls.update();
  }

  // m, what lines, dots and arrows are measured by: the scene, or what is seen of it from near by.
  measureOfLines() {
    const { position, fov } = this.camera, seen = 2 * position.distanceTo(this.controls.target) * Math.tan((fov * Math.PI) / 360);
    return Math.min(this.size, 1.25 * seen);
  }

  lookAt(point, radius) {
    this.look(point, this.camera.position.clone().sub(this.controls.target).normalize(), radius);
  }

  look(point, away, radius) {
    this.controls.target.copy(point);
    this.camera.position.copy(point).addScaledVector(away, this.distanceFor(radius));
    this.controls.update();
    this.changed();
  }

  resize(width, height) {
    this.renderer.setPixelRatio(Math.min(2, globalThis.devicePixelRatio || 1));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
  }

  // Puts the bodies where they are at a frame and the part of the way to the next one.
  place(frame, part) {
    const p = new Float64Array(7);
    for (let i = 0; i < this.groups.length; i++) {
      const group = this.groups[i], there = this.replay.pose(i, frame, part, p);
      group.visible = there;
      if (there) {
        group.position.set(p[0], p[1], p[2]);
        group.quaternion.set(p[3], p[4], p[5], p[6]);
      }
    }
    this.colour(frame);
    const light = this.replay.lightAt(frame);
    if (light !== this.lit) this.setLight(light);
    if (this.follows >= 0) this.follow(frame, part);
  }

  // "own", "dig" or "heat"
  colour(frame) {
    const tint = new Color(), r = this.replay;
    for (let i = 0; i < this.groups.length; i++) {
      const k = r.key(i, frame);
      for (const mesh of this.groups[i].children) {
        const { color, emissive, userData } = mesh.material;
        if (!userData.plain) continue;
        color.copy(userData.plain);
        emissive.set(0);
        if (this.colouring === "dig" && k >= 0 && r.key_dig[k]) {
          color.lerp(tint.setRGB(...digColour(r.key_dig[k])), 0.85);
          if (!(r.key_flags[k] & 1)) color.lerp(tint.setRGB(0.12, 0.12, 0.13), 0.55);
        }
        if (this.colouring === "heat" && r.key_temperature) {
          const t = r.key_temperature[k], grey = 0.08 * (color.r + color.g + color.b) + 0.12;
          if (t > 0) color.setRGB(...heatColour((t - r.heat[0]) / (r.heat[1] - r.heat[0])));
          else color.setRGB(grey, grey, grey);
        }
        if (i === this.picked) emissive.setRGB(0.02, 0.10, 0.28);
      }
    }
  }

  // The body under a point of the canvas (pixels of CSS), or -1.
  hit(x, y) {
    const box = this.canvas.getBoundingClientRect();
    const ray = new Raycaster();
    ray.setFromCamera(new Vector2((x / box.width) * 2 - 1, 1 - (y / box.height) * 2), this.camera);
    const seen = this.groups.filter((g) => g.visible);
    const hit = ray.intersectObjects([...seen, ...this.planes.filter((m) => m.userData.body < 0)], true)[0];
    return hit ? hit.object.userData.body : -1;
  }

  // Where a point is on the canvas, pixels of CSS; null when it is behind the camera.
  project(point) {
    const v = (point.isVector3 ? point.clone() : new Vector3(...point)).project(this.camera);
    if (v.z > 1) return null;
    return [(v.x + 1) * 0.5 * this.canvas.clientWidth, (1 - v.y) * 0.5 * this.canvas.clientHeight];
  }

  draw() { this.renderer.render(this.scene, this.camera); }
}
