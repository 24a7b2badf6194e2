/** Plan markers over the scene: support polygon, COM, ZMP, DCM and goal. */
import * as THREE from 'three';
import { Line2 } from 'three/addons/lines/Line2.js';
import { LineGeometry } from 'three/addons/lines/LineGeometry.js';
import { LineMaterial } from 'three/addons/lines/LineMaterial.js';
import { finite, type Goal, type State, type Value } from './protocol';

export const colours = {
  support: '#2e9e6b',
  com: '#20262d',
  zmp: '#d8402f',
  dcm: '#2f6fd8',
  goal: '#e08a00',
};

type Shown = Pick<State, 'support' | 'support_height' | 'com' | 'zmp' | 'dcm'> & {
  goal: Pick<Goal, 'soles' | 'hands' | 'com'> | null;
};

/** A flat area with an outline. */
class Area {
  readonly group = new THREE.Group();
  private readonly rim: Line2;
  private readonly fill: THREE.Mesh;
  private shown = '';

  constructor(colour: string, opacity: number, width: number, dashes = 0) {
    const style = { color: colour, linewidth: width, transparent: true, depthTest: false };
    const dashed = { dashed: dashes > 0, dashSize: dashes, gapSize: 0.7 * dashes };
    this.rim = new Line2(new LineGeometry(), new LineMaterial({ ...style, ...dashed }));
    const paint = { color: colour, transparent: true, opacity, depthWrite: false, side: THREE.DoubleSide };
    this.fill = new THREE.Mesh(
      new THREE.BufferGeometry(),
      new THREE.MeshBasicMaterial({
        ...paint,
        polygonOffset: true,
        polygonOffsetFactor: -2,
        polygonOffsetUnits: -2,
      }),
    );
    this.fill.renderOrder = 2;
    this.rim.renderOrder = 3;
    this.group.add(this.fill, this.rim);
    this.group.visible = false;
  }

  show(corners: Value[][]): void {
    const key = JSON.stringify(corners);
    this.group.visible = corners.length >= 3 && corners.every(finite);
    if (!this.group.visible || key === this.shown) return;
    this.shown = key;
    const points = corners.flat() as number[];
    this.rim.geometry.dispose();
    this.rim.geometry = new LineGeometry();
    this.rim.geometry.setPositions([...points, ...points.slice(0, 3)]);
    this.rim.computeLineDistances();
    const triangles = corners.slice(2).flatMap((_, i) => [0, i + 1, i + 2]);
    this.fill.geometry.dispose();
    this.fill.geometry = new THREE.BufferGeometry();
    this.fill.geometry.setAttribute('position', new THREE.Float32BufferAttribute(points, 3));
    this.fill.geometry.setIndex(triangles);
  }

  hide(): void {
    this.group.visible = false;
  }
}

/** Markers visible through the robot. */
function overlay(geometry: THREE.BufferGeometry, color: string, opacity = 1): THREE.Mesh {
  const material = new THREE.MeshBasicMaterial({
    color,
    opacity,
    transparent: true,
    depthTest: false,
    side: THREE.DoubleSide,
  });
  const mesh = new THREE.Mesh(geometry, material);
  mesh.renderOrder = 10;
  return mesh;
}

function put(object: THREE.Object3D, place: Value[] | null): void {
  object.visible = place !== null && finite(place);
  if (object.visible) object.position.set(...(place as [number, number, number]));
}

export class Markers {
  readonly root = new THREE.Group();
  private readonly support = new Area(colours.support, 0.28, 2.5);
  private readonly soles: [Area, Area];
  private readonly com: THREE.Group;
  private readonly zmp: THREE.Group;
  private readonly dcm: THREE.Mesh;
  private readonly goalCom: THREE.Mesh;
  private readonly hands: [THREE.Mesh, THREE.Mesh];
  private readonly plumb: THREE.Line;

  /** `size`: size of the robot [m]. */
  constructor(private readonly size: number) {
    const r = 0.035 * size;
    const goalSole = (): Area => new Area(colours.goal, 0.3, 2.5, 0.04 * size);
    this.soles = [goalSole(), goalSole()];
    this.com = comMark(r);
    this.zmp = cross(1.1 * r, colours.zmp);
    this.dcm = overlay(new THREE.RingGeometry(0.6 * r, r, 28), colours.dcm);
    this.goalCom = overlay(new THREE.RingGeometry(1.25 * r, 1.6 * r, 36), colours.goal);
    const hand = (): THREE.Mesh => overlay(new THREE.SphereGeometry(1.2 * r, 20, 14), colours.goal, 0.65);
    this.hands = [hand(), hand()];
    this.plumb = new THREE.Line(
      new THREE.BufferGeometry().setFromPoints([new THREE.Vector3(), new THREE.Vector3(0, 0, -1)]),
      new THREE.LineBasicMaterial({ color: colours.com, transparent: true, opacity: 0.55, depthTest: false }),
    );
    this.plumb.renderOrder = 9;
    const flat = [this.zmp, this.dcm];
    this.root.add(
      this.support.group,
      ...this.soles.map(({ group }) => group),
      this.com,
      ...flat,
      this.goalCom,
    );
    this.root.add(...this.hands, this.plumb);
  }

  /** Shows every marker, anywhere. */
  showAll(camera: THREE.Camera): void {
    const corners = [
      [0, 0, 0],
      [1, 0, 0],
      [0, 1, 0],
    ];
    const place = [0, 0, 0];
    this.show(
      {
        support: corners.map((corner) => corner.slice(0, 2)),
        support_height: 0,
        com: place,
        zmp: [0, 0],
        dcm: [0, 0],
        goal: { soles: [corners, corners], hands: [place, place], com: place },
      },
      camera,
    );
  }

  /** `camera`: billboards turn towards it. */
  show(state: Shown, camera: THREE.Camera): void {
    this.root.visible = true;
    const ground = state.support_height ?? 0;
    const above = ground + 0.004 * this.size;
    this.support.show(state.support.map((vertex) => [...vertex, above]));
    put(this.com, state.com);
    put(this.plumb, state.com);
    this.plumb.scale.z = Math.max(1e-6, (state.com[2] ?? ground) - ground);
    put(this.zmp, [...state.zmp, above]);
    put(this.dcm, [...state.dcm, above]);

    const goal = state.goal;
    this.soles.forEach((area, i) => (goal ? area.show(goal.soles[i]!) : area.hide()));
    this.hands.forEach((hand, i) => put(hand, goal?.hands[i]?.slice(0, 3) ?? null));
    put(this.goalCom, goal?.com ?? null);
    this.com.quaternion.copy(camera.quaternion);
    this.goalCom.quaternion.copy(camera.quaternion);
  }
}

/** The usual sign for a centre of mass: a disc in quarters, black and white. */
function comMark(r: number): THREE.Group {
  const group = new THREE.Group();
  group.add(overlay(new THREE.CircleGeometry(1.15 * r, 36), colours.com));
  for (const quarter of [0, 1, 2, 3]) {
    const colour = quarter % 2 === 0 ? '#ffffff' : colours.com;
    const piece = overlay(new THREE.CircleGeometry(r, 12, (quarter * Math.PI) / 2, Math.PI / 2), colour);
    piece.renderOrder = 11;
    group.add(piece);
  }
  return group;
}

function cross(r: number, colour: string): THREE.Group {
  const group = new THREE.Group();
  for (const angle of [Math.PI / 4, -Math.PI / 4]) {
    group.add(overlay(new THREE.PlaneGeometry(2.2 * r, 0.5 * r).rotateZ(angle), colour));
  }
  return group;
}
