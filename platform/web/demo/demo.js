// SPDX-License-Identifier: Apache-2.0
import '../doppel-avatar.js';

const avatar = document.querySelector('doppel-avatar'), said = document.querySelector('#said');
const clip = document.querySelector('#clip'), play = document.querySelector('#play');
const face = document.querySelector('#face'), expression = document.querySelector('#expression'), weight = document.querySelector('#weight');
let dropped = null, weights = {};

avatar.addEventListener('progress', ({ detail }) => { said.textContent = `Loading: ${Math.round(100 * detail.loaded / detail.total)} %`; });
avatar.addEventListener('load', ({ detail }) => {
  said.textContent = `${detail.name || 'A person'}: ${detail.splatCount} splats`;
  clip.replaceChildren(...avatar.person.clips.map((c, i) => new Option(`${c.name} (${c.duration.toFixed(1)} s)`, i)));
  play.textContent = avatar.paused ? 'Play' : 'Pause';
  const drawn = avatar.person.expressions.filter(e => e.drawn);
  face.hidden = !drawn.length;
  expression.replaceChildren(...drawn.map(({ name }) => new Option(name)));
  weights = {};
  weight.value = 0;
});
avatar.addEventListener('error', ({ detail }) => { said.textContent = detail.message; });
clip.addEventListener('change', () => avatar.setAttribute('clip', clip.value));
play.addEventListener('click', () => {
  if (avatar.paused) avatar.play();
  else avatar.pause();
  play.textContent = avatar.paused ? 'Play' : 'Pause';
});
expression.addEventListener('change', () => { weight.value = weights[expression.value] ?? 0; });
weight.addEventListener('input', () => {
  weights[expression.value] = Number(weight.value);
  avatar.person?.setExpression(weights);
  avatar.redraw();
});
addEventListener('dragover', event => event.preventDefault());
addEventListener('drop', event => {
  event.preventDefault();
  const [file] = event.dataTransfer.files;
  if (!file) return;
  if (dropped) URL.revokeObjectURL(dropped);
  dropped = URL.createObjectURL(file);
  avatar.setAttribute('clip', '0');
  avatar.setAttribute('src', dropped);
});
