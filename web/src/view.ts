/** Renderer, camera and light. z is up. */
import * as THREE from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';

const horizon = '#e8ecf0';
const slow = 70; // frame time above which detail is reduced [ms]

export class View {
  follow = true;
  readonly software: boolean;
  readonly scene = new THREE.Scene();
  readonly camera: THREE.PerspectiveCamera;
  private readonly renderer: THREE.WebGLRenderer;
  private readonly controls: OrbitControls;
  private readonly key = new THREE.DirectionalLight('#fff6ea', 2.0);
  private readonly centre = new THREE.Vector3();
  private detail = Math.min(2, window.devicePixelRatio);
  private mean = 16; // mean frame time [ms]
  private last = 0;

  /** `size`: nominal height of the robot's centre of mass [m]. */
  constructor(
    canvas: HTMLCanvasElement,
    private readonly size: number,
  ) {
    const { gl, software } = context(canvas);
    this.software = software;
    if (software) this.detail = 0.8;
    this.renderer = new THREE.WebGLRenderer({ canvas, context: gl });
    this.renderer.debug.checkShaderErrors = false; // checking is slow
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFShadowMap;
    this.renderer.toneMapping = THREE.NeutralToneMapping;
    this.camera = new THREE.PerspectiveCamera(38, 1, 0.05 * size, 400 * size);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = true;
    this.controls.dampingFactor = 0.12;
    this.controls.minDistance = 0.8 * size;
    this.controls.maxDistance = 40 * size;
    this.controls.maxPolarAngle = 0.52 * Math.PI;
    this.scene.background = sky();
    this.scene.fog = new THREE.Fog(horizon, 14 * size, 60 * size);
    this.addLights();
    this.reset(new THREE.Vector3(0, 0, size));
    addEventListener('resize', () => this.resize());
    this.resize();
  }

  /** Looks at the robot from behind its right shoulder. */
  reset(target: THREE.Vector3): void {
    this.centre.copy(target);
    this.controls.target.copy(target);
    this.camera.position.copy(target).add(new THREE.Vector3(-3.4, -2.7, 1.9).multiplyScalar(this.size));
    this.controls.update();
  }

  /** Moves camera and light along with the target. */
  watch(target: THREE.Vector3): void {
    const step = target.clone().sub(this.centre);
    if (this.follow) {
      if (step.length() < 10 * this.size) step.multiplyScalar(0.15); // smoothly
      this.centre.add(step);
      this.controls.target.add(step);
      this.camera.position.add(step);
    }
    this.key.target.position.copy(target);
    this.key.position.copy(target).add(new THREE.Vector3(-2.2, -3.0, 6.5).multiplyScalar(this.size));
  }

  /**
   * Draws everything once, seen or not, with no more detail than the machine can bear, and waits until it is done.
   * Shaders are compiled at the first use, and buffers made; without a graphics card that may take a second, for which a
   * page that drives would be silent.
   */
  warmUp(): void {
    const before = new Map<THREE.Object3D, { visible: boolean; frustumCulled: boolean }>();
    this.scene.traverse((object) => {
      before.set(object, { visible: object.visible, frustumCulled: object.frustumCulled });
      Object.assign(object, { visible: true, frustumCulled: false });
    });
    this.timeOfPicture();
    while (this.timeOfPicture() > slow && this.lessDetail());
    for (const [object, was] of before) Object.assign(object, was);
  }

  /** `calm`: the detail may be reduced, which takes time. */
  draw(now: number, calm: boolean): void {
    if (this.last > 0) this.mean += 0.1 * (Math.min(now - this.last, 500) - this.mean);
    this.last = now;
    if (calm && this.mean > slow) {
      this.mean = 16;
      this.lessDetail();
    }
    this.controls.update();
    this.renderer.render(this.scene, this.camera);
  }

  /** Time to render one frame completely [ms]. */
  private timeOfPicture(): number {
    const began = performance.now();
    this.renderer.render(this.scene, this.camera);
    const gl = this.renderer.getContext();
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4)); // waits, unlike finish()
    return performance.now() - began;
  }

  private resize(): void {
    const { innerWidth: width, innerHeight: height } = window;
    this.renderer.setPixelRatio(this.detail);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
  }

  /** Reduces detail on a slow machine: fewer pixels first, then coarser shadows. False if nothing is left to reduce. */
  private lessDetail(): boolean {
    if (this.detail > 0.6) {
      this.detail = Math.max(0.6, 0.7 * this.detail);
      this.resize();
      return true;
    }
    if (this.key.shadow.mapSize.x <= 512) return false;
    this.key.shadow.mapSize.setScalar(512);
    this.key.shadow.map?.dispose();
    this.key.shadow.map = null;
    return true;
  }

  private addLights(): void {
    const { key, size } = this;
    key.castShadow = true;
    key.shadow.mapSize.setScalar(2048);
    key.shadow.radius = 2;
    key.shadow.bias = -0.0004;
    key.shadow.normalBias = 0.01 * size;
    Object.assign(key.shadow.camera, { left: -5 * size, right: 5 * size, top: 5 * size, bottom: -5 * size });
    Object.assign(key.shadow.camera, { near: 0.5 * size, far: 16 * size });
    const fill = new THREE.DirectionalLight('#dbe8ff', 0.5);
    fill.position.set(-3, 4, 3);
    this.scene.add(key, key.target, fill, new THREE.HemisphereLight('#ffffff', '#dfdedb', 2.0));
  }
}

/** Without a graphics card antialiasing, the most expensive part, is left out. */
function context(canvas: HTMLCanvasElement): { gl: WebGL2RenderingContext; software: boolean } {
  const fast = canvas.getContext('webgl2', { antialias: true, failIfMajorPerformanceCaveat: true });
  const gl = fast ?? canvas.getContext('webgl2', { antialias: false });
  if (!gl) throw new Error('the browser has no WebGL 2');
  return { gl, software: !fast };
}

/** Darker above, lighter at the horizon. */
function sky(): THREE.Texture {
  const canvas = document.createElement('canvas');
  canvas.width = 4;
  canvas.height = 256;
  const pen = canvas.getContext('2d')!;
  const gradient = pen.createLinearGradient(0, 0, 0, 256);
  gradient.addColorStop(0, '#c3d0de');
  gradient.addColorStop(0.55, horizon);
  gradient.addColorStop(1, horizon);
  pen.fillStyle = gradient;
  pen.fillRect(0, 0, 4, 256);
  const texture = new THREE.CanvasTexture(canvas);
  texture.colorSpace = THREE.SRGBColorSpace;
  return texture;
}
