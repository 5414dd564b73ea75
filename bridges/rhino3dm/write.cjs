// SPDX-License-Identifier: Apache-2.0
// A GoTools .g2 file as a Rhino .3dm file, by McNeel's rhino3dm (openNURBS; `npm install rhino3dm`).
//   node write.cjs IN.g2 OUT.3dm MILLIMETRES-IN-ONE-UNIT
// knurl runs it for outputs that end in .3dm, before without arguments, to see that the package is there. Exit 1 with
// one line on standard error: what is in the way.
'use strict';
const fs = require('fs');

const CURVE = 100, SURFACE = 200;

function fail(text) {
  process.stderr.write(text + '\n');
  process.exit(1);
}

// Numbers of the file one after the other, without holding them all.
function* numbers(path) {
  const file = fs.openSync(path, 'r'), block = Buffer.alloc(1 << 20);
  let rest = '';
  for (let n; (n = fs.readSync(file, block, 0, block.length, null)) > 0;) {
    const words = (rest + block.toString('latin1', 0, n)).split(/\s+/);
    rest = words.pop();
    for (const word of words) if (word) yield Number(word);
  }
  if (rest) yield Number(rest);
  fs.closeSync(file);
}

// Knots without the first and the last, which openNURBS leaves out.
function setKnots(list, knots) {
  for (let i = 1; i + 1 < knots.length; i++) list.set(i - 1, knots[i]);
}

function readSpline(next, nvars) {
  const s = {dim: next(), rational: next() === 1, count: [], order: [], knots: []};
  for (let d = 0; d < nvars; d++) {
    s.count[d] = next(), s.order[d] = next();
    s.knots[d] = Array.from({length: s.count[d] + s.order[d]}, next);
  }
  return s;
}

// Homogeneous coordinates, as both sides have them.
function readPoint(next, s) {
  const p = [next(), next(), next()];
  p.push(s.rational ? next() : 1);
  return p;
}

function makeCurve(rhino, next) {
  const s = readSpline(next, 1), curve = new rhino.NurbsCurve(3, s.rational, s.order[0], s.count[0]);
  setKnots(curve.knots(), s.knots[0]);
  const points = curve.points();
  for (let i = 0; i < s.count[0]; i++) points.set(i, readPoint(next, s));
  return curve;
}

function makeSurface(rhino, next) {
  const s = readSpline(next, 2);
  const surface = rhino.NurbsSurface.create(3, s.rational, s.order[0], s.order[1], s.count[0], s.count[1]);
  setKnots(surface.knotsU(), s.knots[0]);
  setKnots(surface.knotsV(), s.knots[1]);
  const points = surface.points();
  for (let j = 0; j < s.count[1]; j++) for (let i = 0; i < s.count[0]; i++) points.set(i, j, readPoint(next, s));
  return surface;
}

function unitOf(rhino, mm) {
  const u = rhino.UnitSystem, table = [[0.001, u.Microns], [1, u.Millimeters], [10, u.Centimeters], [25.4, u.Inches],
    [304.8, u.Feet], [1000, u.Meters]];
  const found = table.find(row => row[0] === mm);
  return found ? found[1] : fail('a unit of ' + mm + ' mm has no name in .3dm files: um, mm, cm, m, in and ft have');
}

function convert(rhino, from, to, mm) {
  const words = numbers(from), file = new rhino.File3dm();
  const next = () => {
    const word = words.next();
    if (word.done || Number.isNaN(word.value)) fail(from + ': ends, or holds what is no number');
    return word.value;
  };
  file.settings().modelUnitSystem = unitOf(rhino, mm);
  for (let word = words.next(); !word.done; word = words.next()) {
    const header = [next(), next(), next()], attributes = new rhino.ObjectAttributes();
    const color = Array.from({length: header[2]}, next);
    let shape;
    if (word.value === CURVE) shape = makeCurve(rhino, next);
    else if (word.value === SURFACE) shape = makeSurface(rhino, next);
    else fail(word.value === 700 ? 'volumes have no place in .3dm files: write .vtu, .mesh or .g2'
                                 : 'trimmed faces are not written to .3dm files: write .step or .g2');
    if (color.length >= 3) {
      attributes.objectColor = {r: color[0], g: color[1], b: color[2], a: 255};
      attributes.colorSource = rhino.ObjectColorSource.ColorFromObject;
    }
    if (!shape.isValid) fail('openNURBS finds a spline invalid');
    file.objects().add(shape, attributes);
    shape.delete(), attributes.delete(); // they lie in the memory of the compiled library
  }
  fs.writeFileSync(to, file.toByteArray());
}

let found;
try {
  found = require.resolve('rhino3dm');
} catch (error) {
  fail('the node package rhino3dm is missing: npm install rhino3dm (NODE_PATH says where packages are)');
}
if (process.argv.length > 2)
  require(found)()
      .then(rhino => convert(rhino, process.argv[2], process.argv[3], Number(process.argv[4])))
      .catch(error => fail(String(error.message || error)));
