// SPDX-License-Identifier: Apache-2.0
import type { Camera, Doppel, Projection } from './doppel.js';

/** Blends projected splats in a WebGL2 context of yours. Sets the state that it needs and restores none. */
export class SplatBlender {
  constructor(gl: WebGL2RenderingContext);
  /** Bytes of the last upload. */
  readonly uploadedBytes: number;
  upload(projection: Projection): void;
  /** Draws `count` uploaded splats from number `first` on into the bound framebuffer. sampleX, sampleY: from the middle of a pixel, px. */
  blend(first: number, count: number, width: number, height: number, sampleX?: number, sampleY?: number): void;
  dispose(): void;
}

/** Pictures of persons on a canvas, which it takes for itself. */
export class SplatRenderer {
  /** Throws DoppelError with code DPL_ERROR_UNSUPPORTED where there is no WebGL2 or it cannot draw this. */
  constructor(canvas: HTMLCanvasElement | OffscreenCanvas,
              options?: { onLost?: () => void; onRestored?: () => void; xrCompatible?: boolean });
  /** RGBA8 is coarser: the device refuses float targets. */
  readonly target: 'RGBA16F' | 'RGBA8';
  readonly lost: boolean;
  readonly context: WebGL2RenderingContext;
  /** Bytes that the last frame sent to the graphics device. */
  readonly uploadedBytes: number;
  /** False: the graphics device is lost. */
  draw(person: Doppel, camera: Camera): boolean;
  /** right and rightAt: null for one view. Corners are lower left ones, px. False: the graphics device is lost. */
  drawEyes(person: Doppel, left: Camera, right: Camera | null, framebuffer: WebGLFramebuffer | null, leftAt: { x: number; y: number },
           rightAt: { x: number; y: number } | null): boolean;
  /** The last picture: premultiplied, 4 bytes a pixel, top row first. Waits for the device. */
  read(): Uint8ClampedArray;
  dispose(): void;
}
