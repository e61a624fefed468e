// Stage: camera, lights and meshes of the frame that is shown.

import {
  AmbientLight,
  BackSide,
  Box3,
  BufferAttribute,
  BufferGeometry,
  Color,
  DirectionalLight,
  DoubleSide,
  FrontSide,
  Mesh,
  MeshBasicMaterial,
  MeshLambertMaterial,
  MeshPhongMaterial,
  PerspectiveCamera,
  Plane,
  Scene,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

const STEEL = 0x8d99a8;
/** Colours and opacities of gel: amber, clear enough to see the projectile, paler where it is cut. */
const GEL = 0xd9922e;
const GEL_OPACITY = 0.38;
const GEL_SECTION = 0xf2c27a;
const GEL_SECTION_OPACITY = 0.72;
const OPEN_ANGLE = 28;

/** Directions from the gel to the camera in each view. */
const DIRECTIONS = {
  overview: [0.42, -1, 0.42],
  front: [0, -1, 0],
  side: [1, -0.001, 0],
  above: [0, -0.001, 1],
};

/** Stage of the view; `changed` is called after each picture. */
export class Stage {
  constructor(canvas, isDeep) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio));
    this.renderer.localClippingEnabled = true;
    this.renderer.setClearColor(0x000000, 0);
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(OPEN_ANGLE, 1.6, 1e-3, 1e3);
    // A deep gel lies on its side: the projectile flies to the right.
    this.isDeep = isDeep;
    this.camera.up.set(isDeep ? 1 : 0, 0, isDeep ? 0 : 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.render());
    this.clip = new Plane(new Vector3(0, 1, 0), 0);
    this.clipSection = new Plane(new Vector3(0, 1, 0), 0);
    this.addLights();
    this.makeMaterials();
    this.meshes = [];
  }

  addLights() {
    const lamp = new DirectionalLight(0xffffff, 2.0);
    lamp.position.set(-0.6, 1, 0.6);
    this.camera.add(lamp);
    this.scene.add(this.camera, new AmbientLight(0xffffff, 1.5));
  }

  makeMaterials() {
    const lambert = (more) => new MeshLambertMaterial({ side: DoubleSide, ...more });
    const gel = (side) => new MeshPhongMaterial({
      color: GEL,
      specular: 0x665533,
      shininess: 40,
      transparent: true,
      opacity: GEL_OPACITY,
      depthWrite: false,
      side,
      clippingPlanes: [this.clip],
    });
    const section = (more) => new MeshBasicMaterial({ side: DoubleSide, clippingPlanes: [this.clipSection], ...more });
    this.materials = {
      surface: lambert({ vertexColors: true, clippingPlanes: [this.clip] }),
      section: section({ vertexColors: true }),
      body: lambert({ color: STEEL }),
      gelBack: gel(BackSide),
      gelFront: gel(FrontSide),
      gelSection: section({ color: GEL_SECTION, transparent: true, opacity: GEL_SECTION_OPACITY }),
    };
    this.wire = new MeshBasicMaterial({
      wireframe: true,
      color: new Color(0x000000),
      transparent: true,
      opacity: 0.28,
      clippingPlanes: [this.clipSection],
    });
  }

  /** Returns the meshes of a shape: coloured by a field if it has colours, else as gel or steel. */
  meshesOf({ role, colours }, geometry) {
    const mesh = (name, order) => Object.assign(new Mesh(geometry, this.materials[name]), { renderOrder: order });
    if (colours || role === "body") {
      return [mesh(role, role === "surface" ? 1 : 0)];
    }
    // The far side of clear gel is drawn before the near side, and the section before both.
    return role === "surface" ? [mesh("gelBack", 1), mesh("gelFront", 2)] : [mesh("gelSection", 3)];
  }

  /**
   * Replaces the meshes; each shape brings positions, triangles, normals, a role, and colours where a field is shown. The lines
   * of the section stand before it by a small offset, m.
   */
  show(shapes, isSectionShown, hasLines, lineOffset) {
    for (const mesh of this.meshes) {
      this.scene.remove(mesh);
      mesh.geometry.dispose();
    }
    this.meshes = shapes.flatMap((shape) => {
      const geometry = new BufferGeometry();
      const attributes = { position: shape.positions, normal: shape.normals, color: shape.colours };
      for (const [name, numbers] of Object.entries(attributes).filter(([, numbers]) => numbers)) {
        geometry.setAttribute(name, new BufferAttribute(numbers, 3));
      }
      geometry.setIndex(new BufferAttribute(shape.triangles, 1));
      const meshes = this.meshesOf(shape, geometry);
      if (shape.role !== "section") {
        return meshes;
      }
      const lines = Object.assign(new Mesh(geometry, this.wire), { renderOrder: 4, visible: isSectionShown && hasLines });
      lines.position.y = -lineOffset;
      meshes.forEach((mesh) => Object.assign(mesh, { visible: isSectionShown }));
      return [...meshes, lines];
    });
    this.scene.add(...this.meshes);
  }

  /**
   * Cuts the gel at the height y, m; nothing in front of it is drawn, but for a lip of the surface that closes the gap to the
   * section. Without a height the gel is whole.
   */
  cut(y, lip) {
    this.clip.constant = y === null ? 1e9 : lip - y;
    this.clipSection.constant = this.clip.constant + lip;
  }

  /** Makes the surface of the gel transparent or not. */
  setTransparent(isTransparent) {
    Object.assign(this.materials.surface, {
      transparent: isTransparent,
      opacity: isTransparent ? 0.25 : 1,
      depthWrite: !isTransparent,
      needsUpdate: true,
    });
  }

  /** Looks at a box, m, from a named direction. */
  look(name, low, high) {
    const box = new Box3(new Vector3(...low), new Vector3(...high));
    const [centre, size] = [box.getCenter(new Vector3()), box.getSize(new Vector3())];
    const towards = new Vector3(...DIRECTIONS[name]).normalize();
    const right = new Vector3().crossVectors(this.camera.up, towards).normalize();
    const up = new Vector3().crossVectors(towards, right);
    const tangent = Math.tan((OPEN_ANGLE * Math.PI) / 360);
    const needed = [0, 1, 2, 3, 4, 5, 6, 7].map((bits) => {
      const signs = [1, 2, 4].map((bit) => (bits & bit ? 0.5 : -0.5));
      const corner = new Vector3(...signs).multiply(size);
      const across = Math.max(Math.abs(corner.dot(up)), Math.abs(corner.dot(right)) / this.camera.aspect);
      return (1.08 * across) / tangent + corner.dot(towards);
    });
    const distance = Math.max(...needed);
    this.camera.position.copy(centre).addScaledVector(towards, distance);
    this.camera.near = distance / 500;
    this.camera.far = distance * 20;
    this.camera.updateProjectionMatrix();
    this.controls.target.copy(centre);
    this.controls.update();
    this.render();
  }

  /** Turns the camera about the gel by angles, rad. */
  turn(across, along) {
    const away = this.camera.position.clone().sub(this.controls.target);
    const right = new Vector3().crossVectors(this.camera.up, away).normalize();
    away.applyAxisAngle(this.camera.up, across);
    const turned = away.clone().applyAxisAngle(right, along);
    const steep = Math.abs(turned.clone().normalize().dot(this.camera.up));
    this.camera.position.copy(this.controls.target).add(steep < 0.99 ? turned : away);
    this.controls.update();
    this.render();
  }

  /** Fits the picture to its place on the page. */
  resize(width, height) {
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.render();
  }

  render() {
    this.renderer.render(this.scene, this.camera);
  }
}
