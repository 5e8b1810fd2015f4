// SPDX-License-Identifier: Apache-2.0
// The script of pages that hold a person in themselves: report.html and what `doppel share` writes (reconstruction/output/page). The page
// has a figure #person with a still picture, and the bytes of avatar and module in base64. This script lays a <doppel-avatar> over the
// picture. The picture stays where scripts are off, and where the person cannot be drawn.
import { DoppelAvatarElement } from '../doppel-avatar.js';
import { labelOf } from './label.js';
import { unlzma } from './lzma.js';

const MOST_CLIPS = 6;

const figure = document.querySelector('#person');
const still = figure.querySelector('img');

function bytesOf(id) {
  const holder = document.getElementById(id);
  if (!holder) throw new Error('this page is cut off; get it again');
  let text;
  try {
    text = atob(holder.textContent);
  } catch {
    throw new Error('this page is damaged; get it again');
  }
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  holder.remove();
  return bytes;
}

function say(sentence) {
  const note = figure.querySelector('.said') ?? figure.appendChild(document.createElement('figcaption'));
  note.className = 'said';
  note.textContent = sentence;
}

function button(label, onClick) {
  const made = document.createElement('button');
  made.type = 'button';
  made.textContent = label;
  made.addEventListener('click', onClick);
  return made;
}

/** A button a clip, and one that stops and goes on. Clip names come from the file and are text. */
function controls(avatar) {
  const row = document.createElement('div');
  row.className = 'moves';
  const clips = avatar.person.clips.slice(0, MOST_CLIPS).map(({ name }, i) => button(labelOf(name), () => {
    avatar.setAttribute('clip', String(i));
    show(i);
    play();
  }));
  const show = current => clips.forEach((clip, i) => clip.setAttribute('aria-pressed', String(i === current)));
  const tell = () => { pause.textContent = avatar.paused ? 'Play' : 'Pause'; };
  const play = () => {
    avatar.play();
    tell();
  };
  const pause = button('', () => {
    if (avatar.paused) avatar.play();
    else avatar.pause();
    tell();
  });
  tell();
  show(0);
  row.append(...clips, pause);
  return row;
}

function live() {
  const urls = [['avatar', 'model/gltf-binary', bytesOf('dpl-avatar')], ['module', 'application/wasm', unlzma(bytesOf('dpl-module'))]];
  const [src, module] = urls.map(([, type, bytes]) => URL.createObjectURL(new Blob([bytes], { type })));
  const avatar = document.createElement('doppel-avatar');
  for (const [name, value] of Object.entries({ src, module, autoplay: '', 'auto-rotate': '', 'camera-controls': '', alt: still?.alt ?? '' }))
    avatar.setAttribute(name, value);
  const forget = () => [src, module].forEach(url => URL.revokeObjectURL(url));
  avatar.addEventListener('first-picture', () => {
    forget();
    figure.classList.add('alive');
    figure.append(controls(avatar));
  }, { once: true });
  avatar.addEventListener('error', ({ detail }) => {
    forget();
    avatar.remove();
    figure.querySelector('.moves')?.remove();
    figure.classList.remove('alive');
    say(`The person cannot move here: ${detail.message}`);
  }, { once: true });
  figure.querySelector('.stage').append(avatar);
}

try {
  if (!globalThis.WebAssembly || !DoppelAvatarElement) throw new Error('this browser has no WebAssembly');
  live();
} catch (error) {
  say(`The person cannot move here: ${error.message}`);
}
