/** Draws the compiled model: any robot in any world. */
import * as THREE from 'three';
import { finite, inWords, type Geom, type Model, type Part, type Value } from './protocol';
import { floorTexture, label, meshGeometry, shape } from './shapes';

const accent = new THREE.Color('#1f7a8c');

export class Robot {
  readonly root = new THREE.Group();
  private readonly bodies: THREE.Group[];
  private readonly bodyOf: Map<Part, number>;
  private guided: number | null = null;

  /** `anisotropy`: sharpness of the distant floor. */
  constructor(model: Model, anisotropy: number) {
    const meshes = model.meshes.map(meshGeometry);
    this.bodies = model.bodies.map(() => new THREE.Group());
    this.bodyOf = new Map(model.parts.map(({ name, body }) => [name, body]));
    this.root.add(...this.bodies);
    this.root.visible = false; // until the poses are known
    for (const geom of model.geoms) this.bodies[geom.body]?.add(drawing(geom, meshes, anisotropy));
    for (const site of model.sites.filter(({ visible }) => visible)) this.root.add(place(site, model.size));
  }

  /** Places every body: x y z qw qx qy qz. */
  pose(bodies: Value[][]): void {
    bodies.forEach((pose, i) => {
      const body = this.bodies[i];
      if (!body || !finite(pose)) return;
      const [x, y, z, qw, qx, qy, qz] = pose as [number, number, number, number, number, number, number];
      body.position.set(x, y, z);
      body.quaternion.set(qx, qy, qz, qw);
    });
    this.root.visible = true;
  }

  /** Position of a part's body. */
  position(part: Part): THREE.Vector3 {
    return this.bodies[this.bodyOf.get(part) ?? 0]!.position;
  }

  /** Highlights the guided part. */
  highlight(part: Part): void {
    const body = this.bodyOf.get(part) ?? null;
    if (body === this.guided) return;
    this.tint(this.guided, 0);
    this.tint(body, 0.35);
    this.guided = body;
  }

  private tint(body: number | null, intensity: number): void {
    if (body === null) return;
    for (const child of this.bodies[body]!.children) {
      const material = (child as THREE.Mesh).material;
      if (material instanceof THREE.MeshStandardMaterial) {
        material.emissive.copy(accent);
        material.emissiveIntensity = intensity;
      }
    }
  }
}

function drawing(geom: Geom, meshes: THREE.BufferGeometry[], anisotropy: number): THREE.Mesh {
  const [r, g, b, opacity] = geom.rgba;
  const material = new THREE.MeshStandardMaterial({
    color: new THREE.Color().setRGB(r, g, b, THREE.SRGBColorSpace),
    roughness: 0.9 - 0.5 * Math.min(1, Math.max(0, geom.shine)),
    transparent: opacity < 1,
    opacity,
  });
  const geometry = shape(geom, meshes);
  if (geom.type === 'plane') {
    const { width, height } = (geometry as THREE.PlaneGeometry).parameters;
    material.map = floorTexture(width, height, anisotropy);
  }
  const mesh = new THREE.Mesh(geometry, material);
  mesh.position.set(...geom.pos);
  const [qw, qx, qy, qz] = geom.quat;
  mesh.quaternion.set(qx, qy, qz, qw);
  mesh.castShadow = geom.type !== 'plane';
  mesh.receiveShadow = true;
  if (geom.body === 0 && geom.type === 'box') mesh.add(edges(geometry));
  return mesh;
}

/** Edges of the world's boxes, so that steps are visible from above. */
function edges(geometry: THREE.BufferGeometry): THREE.LineSegments {
  const material = new THREE.LineBasicMaterial({ color: '#4a4238', transparent: true, opacity: 0.35 });
  return new THREE.LineSegments(new THREE.EdgesGeometry(geometry), material);
}

function place(site: Model['sites'][number], size: number): THREE.Group {
  const group = new THREE.Group();
  const dot = new THREE.Mesh(
    new THREE.SphereGeometry(0.028 * size, 20, 14),
    new THREE.MeshStandardMaterial({ color: '#d8402f', roughness: 0.4 }),
  );
  const name = label(inWords(site.name));
  name.position.z = 0.1 * size;
  group.add(dot, name);
  group.position.set(...site.pos);
  return group;
}
