/** MuJoCo's shapes as three.js geometries, in MuJoCo's axes (z is the axis of capsules and cylinders). */
import * as THREE from 'three';
import { toCreasedNormals } from 'three/addons/utils/BufferGeometryUtils.js';
import type { Geom, Model } from './protocol';

const boundless = 50; // half size of an infinite plane [m]
const crease = 0.5; // edges sharper than this are not smoothed [rad]

function bytes(base64: string): ArrayBuffer {
  return Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0)).buffer;
}

export function meshGeometry(mesh: Model['meshes'][number]): THREE.BufferGeometry {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(bytes(mesh.vertices)), 3));
  geometry.setIndex(new THREE.BufferAttribute(new Uint32Array(bytes(mesh.faces)), 1));
  return toCreasedNormals(geometry, crease);
}

export function shape(geom: Geom, meshes: THREE.BufferGeometry[]): THREE.BufferGeometry {
  const [a, b, c] = geom.size;
  switch (geom.type) {
    case 'plane':
      return new THREE.PlaneGeometry(2 * (a || boundless), 2 * (b || boundless));
    case 'sphere':
      return new THREE.SphereGeometry(a, 32, 20);
    case 'capsule':
      return new THREE.CapsuleGeometry(a, 2 * b, 10, 24).rotateX(Math.PI / 2);
    case 'cylinder':
      return new THREE.CylinderGeometry(a, a, 2 * b, 32).rotateX(Math.PI / 2);
    case 'ellipsoid':
      return new THREE.SphereGeometry(1, 32, 20).scale(a, b, c);
    case 'box':
      return new THREE.BoxGeometry(2 * a, 2 * b, 2 * c);
    case 'mesh':
      return meshes[geom.mesh ?? -1] ?? new THREE.BufferGeometry();
  }
}

/** Floor texture: 0.1 m squares with a stronger line every metre, repeated over an area [m]. */
export function floorTexture(width: number, depth: number, anisotropy: number): THREE.Texture {
  const pixels = 512;
  const canvas = document.createElement('canvas');
  canvas.width = canvas.height = pixels;
  const pen = canvas.getContext('2d')!;
  const cell = pixels / 10;
  for (let row = 0; row < 10; ++row) {
    for (let column = 0; column < 10; ++column) {
      pen.fillStyle = (row + column) % 2 === 0 ? '#e6e8ea' : '#dfe2e5';
      pen.fillRect(column * cell, row * cell, cell + 1, cell + 1);
    }
  }
  pen.fillStyle = '#c8cdd3';
  for (let i = 0; i < 10; ++i) {
    pen.fillRect(i * cell, 0, 1.5, pixels);
    pen.fillRect(0, i * cell, pixels, 1.5);
  }
  pen.strokeStyle = '#aeb6bf';
  pen.lineWidth = 4;
  pen.strokeRect(0, 0, pixels, pixels);
  const texture = new THREE.CanvasTexture(canvas);
  texture.wrapS = texture.wrapT = THREE.RepeatWrapping;
  texture.repeat.set(width, depth);
  texture.colorSpace = THREE.SRGBColorSpace;
  texture.anisotropy = anisotropy;
  return texture;
}

/** A label in the scene, of constant size on screen. */
export function label(text: string): THREE.Sprite {
  const canvas = document.createElement('canvas');
  canvas.width = 256;
  canvas.height = 64;
  const pen = canvas.getContext('2d')!;
  pen.font = '600 36px system-ui, sans-serif';
  pen.textAlign = 'center';
  pen.textBaseline = 'middle';
  pen.lineWidth = 8;
  pen.strokeStyle = 'rgba(255, 255, 255, 0.9)';
  pen.strokeText(text, 128, 32);
  pen.fillStyle = '#8c2f25';
  pen.fillText(text, 128, 32);
  const texture = new THREE.CanvasTexture(canvas);
  texture.colorSpace = THREE.SRGBColorSpace;
  const style = { map: texture, depthTest: false, transparent: true, sizeAttenuation: false };
  const sprite = new THREE.Sprite(new THREE.SpriteMaterial(style));
  sprite.scale.set(0.12, 0.03, 1);
  sprite.renderOrder = 20;
  return sprite;
}
