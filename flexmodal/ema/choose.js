// The stabilisation diagram to click in: poles chosen and dropped, residues by least squares, the choice as a file.
// Every number is fitted to all measured lines; only what is drawn is thinned.
(() => {
'use strict'
const SVG = 'http://www.w3.org/2000/svg'
const WIDE = 900, LEFT = 62, RIGHT = 14
const DRAWN = 350 // bins of a drawn curve, two lines each

const put = (parent, tag, attributes = {}, text = null) => {
  const svg = parent.namespaceURI === SVG && parent.tagName !== 'foreignObject' || tag === 'svg'
  const one = svg ? document.createElementNS(SVG, tag) : document.createElement(tag)
  for (const [name, value] of Object.entries(attributes)) one.setAttribute(name, value)
  if (text !== null) one.textContent = text
  parent.append(one)
  return one
}
const numbers = base64 => new Float64Array(Uint8Array.from(atob(base64), c => c.charCodeAt(0)).buffer)
const digits = (value, count) => {
  const short = Number(value.toPrecision(count)), size = Math.abs(short)
  return size && (size < 1e-3 || size >= 1e7) ? value.toExponential(count - 1) : short.toString()
}

// ---- Numbers. A pole is [natural frequency in Hz, damping ratio]. ----

const lambda = ([frequency, damping]) => {
  const omega = 2 * Math.PI * frequency
  return [-damping * omega, omega * Math.sqrt(1 - damping * damping)]
}

// Columns of Re and Im of each residue, then of the residual terms: real parts of all lines, then imaginary ones.
const columnsOf = (omega, poles, power, residuals) => {
  const count = omega.length, columns = []
  const column = at => {
    const one = new Float64Array(2 * count)
    for (let line = 0; line < count; line++) {
      let [re, im] = at(omega[line])
      for (let k = 0; k < power; k++) [re, im] = [-im * omega[line], re * omega[line]]
      one[line] = re
      one[count + line] = im
    }
    columns.push(one)
  }
  for (const pole of poles) {
    const [a, b] = lambda(pole)
    const pair = w => { // 1/(iω − λ) and 1/(iω − λ̄)
      const p = a * a + (w - b) * (w - b), q = a * a + (w + b) * (w + b)
      return [-a / p, -(w - b) / p, -a / q, -(w + b) / q]
    }
    column(w => { const [r, i, s, j] = pair(w); return [r + s, i + j] })
    column(w => { const [r, i, s, j] = pair(w); return [j - i, r - s] })
  }
  const tails = { none: [], real: [1], complex: [1, 0] }[residuals]
  for (const real of tails) {
    const turned = (value) => real ? [value, 0] : [0, value]
    column(() => turned(1))
    column(w => turned(-1 / (w * w)))
  }
  return columns
}

// Least squares by Householder's reflections, columns scaled to length one.
const factored = columns => {
  const rows = columns.length ? columns[0].length : 0
  const scale = columns.map(one => Math.sqrt(one.reduce((sum, x) => sum + x * x, 0)) || 1)
  const work = columns.map((one, k) => one.map(x => x / scale[k]))
  const diagonal = []
  for (let k = 0; k < work.length; k++) {
    const own = work[k]
    let size = 0
    for (let i = k; i < rows; i++) size += own[i] * own[i]
    size = Math.sqrt(size)
    const top = own[k] > 0 ? -size : size
    own[k] -= top
    diagonal.push(top)
    const half = -top * own[k] // vᵀv/2
    for (let j = k + 1; j < work.length; j++) reflect(own, half, k, work[j])
  }
  return { work, diagonal, scale, rows }
}
const reflect = (vector, half, first, onto) => {
  if (half === 0) return
  let along = 0
  for (let i = first; i < onto.length; i++) along += vector[i] * onto[i]
  along /= half
  for (let i = first; i < onto.length; i++) onto[i] -= along * vector[i]
}
const solved = ({ work, diagonal, scale }, right) => {
  const turned = Float64Array.from(right)
  work.forEach((vector, k) => reflect(vector, -diagonal[k] * vector[k], k, turned))
  const answer = new Float64Array(work.length)
  for (let k = work.length - 1; k >= 0; k--) {
    let left = turned[k]
    for (let j = k + 1; j < work.length; j++) left -= work[j][k] * answer[j]
    answer[k] = left / diagonal[k]
  }
  return answer.map((x, k) => x / scale[k])
}

// Residues, residual terms and the synthesised values of every FRF at these poles.
const fitted = (data, poles) => {
  const count = data.omega.length
  if (2 * count <= 2 * poles.length + 4) return null
  const columns = columnsOf(data.omega, poles, data.power, data.residuals)
  const factor = factored(columns)
  let away = 0, whole = 0
  const frfs = data.value.map(value => {
    const terms = solved(factor, value)
    const model = new Float64Array(2 * count)
    columns.forEach((one, k) => { for (let i = 0; i < model.length; i++) model[i] += terms[k] * one[i] })
    for (let i = 0; i < model.length; i++) {
      away += (value[i] - model[i]) ** 2
      whole += value[i] ** 2
    }
    const residue = poles.map((_, k) => [terms[2 * k], terms[2 * k + 1]])
    return { residue, rest: [...terms.slice(2 * poles.length)], model }
  })
  return { frfs, misfit: Math.sqrt(away / whole) }
}

// ---- The panel of one posture. ----

const decoded = raw => {
  const frequency = numbers(raw.frequency), flat = numbers(raw.value), count = frequency.length
  return {
    ...raw, frequency, omega: frequency.map(f => 2 * Math.PI * f),
    value: raw.labels.map((_, k) => flat.subarray(2 * count * k, 2 * count * (k + 1))),
    pole: { frequency: numbers(raw.pole.frequency), damping: numbers(raw.pole.damping),
      order: raw.pole.order, kind: raw.pole.kind },
  }
}

const panel = (root, raw, changed) => {
  const data = decoded(raw), poles = data.pole
  const own = () => raw.chosen.map(pole => ({ pole, from: 'the fit' }))
  let chosen = own(), cursor = -1, shown = 0, answer = null
  const low = data.frequency[0], high = data.frequency[data.frequency.length - 1]
  const x = f => LEFT + (WIDE - LEFT - RIGHT) * (f - low) / (high - low)
  const stable = [...poles.kind.keys()].filter(k => poles.kind[k] === 2)
    .sort((a, b) => poles.frequency[a] - poles.frequency[b] || poles.order[a] - poles.order[b])

  put(root, 'h3', {}, raw.name)
  const frame = () => put(root, 'div', { class: 'wide' })
  const diagram = put(frame(), 'svg', { viewBox: `0 0 ${WIDE} 380`, tabindex: 0, role: 'application', class: 'diagram',
    'aria-label': `Stabilisation diagram, ${raw.name}. Left and right go from one stable pole to the next, up and ` +
      'down through the orders of one, Enter chooses or drops it. All stable poles stand in the table below too.' })
  const said = put(root, 'p', { class: 'said', 'aria-live': 'polite' })
  const tools = put(root, 'div', { class: 'tools' })
  const button = (parent, text, does) => {
    const one = put(parent, 'button', { type: 'button' }, text)
    one.addEventListener('click', does)
    return one
  }
  button(tools, 'Back to the modes of the fit', () => { chosen = own(); refresh('back to the modes of the fit') })
  button(tools, 'Drop all', () => { chosen = []; refresh('all dropped') })
  const picker = put(put(tools, 'label', {}, 'FRF shown '), 'select')
  raw.labels.forEach((label, k) => put(picker, 'option', { value: k }, label))
  picker.addEventListener('change', () => { shown = picker.selectedIndex; draw() })
  const curves = put(frame(), 'svg', { viewBox: `0 0 ${WIDE} 400`, role: 'img', class: 'curves' })
  const legend = put(root, 'p', { class: 'legend' })
  for (const [look, name] of [['measured', 'measured'], ['synthesised', 'synthesised']]) {
    put(put(legend, 'span'), 'i', { class: look })
    legend.lastChild.append(name)
  }
  const table = put(put(root, 'div', { class: 'wide' }), 'table')
  const head = put(put(table, 'thead'), 'tr')
  for (const name of ['chosen mode', 'frequency [Hz]', 'ζ [%]', 'largest |residue| [m/(s·N)]', 'from', ''])
    put(head, 'th', { scope: 'col', class: ['from', ''].includes(name) ? '' : 'n' }, name)
  const body = put(table, 'tbody')
  const fold = put(root, 'details')
  put(fold, 'summary', {}, 'All stable poles, to choose from without the diagram')
  const list = put(fold, 'div', { class: 'columns' })
  const boxes = raw.columns.map(k => {
    const label = put(list, 'label')
    const box = put(label, 'input', { type: 'checkbox' })
    label.append(` ${describe(k)}`)
    box.addEventListener('change', () => beside(k) >= 0 ? drop(beside(k)) : toggle(k))
    return [k, box]
  })

  function describe(k) {
    return `${digits(poles.frequency[k], 6)} Hz, ζ ${digits(100 * poles.damping[k], 3)} %, order ${poles.order[k]}`
  }
  const poleOf = k => [poles.frequency[k], poles.damping[k]]
  const same = (one, other) => one[0] === other[0] && one[1] === other[1]
  // A chosen pole this close is of the same mode, and is exchanged rather than joined by a twin.
  const beside = k => chosen.findIndex(({ pole }) => {
    const [a, b] = lambda(pole), [c, d] = lambda(poleOf(k))
    return Math.hypot(a - c, b - d) <= Math.max(raw.apart * Math.abs(c), raw.least)
  })
  const near = k => chosen.findIndex(({ pole }) => same(pole, poleOf(k)))
  function toggle(k) {
    if (near(k) >= 0) return drop(near(k))
    const twin = beside(k)
    if (twin < 0 && 2 * data.omega.length <= 2 * (chosen.length + 1) + 4)
      return refresh('more modes than the lines can tell')
    const before = twin < 0 ? '' : ` in place of ${digits(chosen.splice(twin, 1)[0].pole[0], 6)} Hz`
    chosen.push({ pole: poleOf(k), from: `order ${poles.order[k]}` })
    chosen.sort((one, other) => one.pole[0] - other.pole[0])
    return refresh(`chose ${describe(k)}${before}`)
  }

  // ---- Pictures ----
  const y = order => 340 - 310 * order / raw.highest
  const axis = (svg, bottom, top) => {
    put(svg, 'path', { class: 'axis', d: `M${LEFT} ${top}V${bottom}H${WIDE - RIGHT}` })
    const step = [1, 2, 5].flatMap(m => [0, 1, 2, 3, 4].map(e => m * 10 ** (e - 1)))
      .sort((a, b) => a - b).find(s => (high - low) / s <= 10) || (high - low)
    for (let f = Math.ceil(low / step) * step; f <= high; f += step) {
      put(svg, 'path', { class: 'axis', d: `M${x(f)} ${bottom}v5` })
      put(svg, 'text', { x: x(f), y: bottom + 18, 'text-anchor': 'middle' }, digits(f, 5))
    }
  }
  const marks = { 0: (u, v) => `M${u} ${v}h.01`, 1: (u, v) => `M${u - 3} ${v - 3}l6 6m0 -6l-6 6`,
    2: (u, v) => `M${u - 3.5} ${v}a3.5 3.5 0 1 0 7 0a3.5 3.5 0 1 0 -7 0` }
  axis(diagram, 340, 22)
  put(diagram, 'text', { x: (LEFT + WIDE) / 2, y: 375, 'text-anchor': 'middle' }, 'Frequency [Hz]')
  put(diagram, 'text', { x: 14, y: 180, transform: 'rotate(-90 14 180)', 'text-anchor': 'middle' }, 'Order [–]')
  for (let order = 0; order <= raw.highest; order += raw.highest > 20 ? 10 : 5)
    put(diagram, 'text', { x: LEFT - 8, y: y(order) + 4, 'text-anchor': 'end' }, order)
  const [least, most] = [Math.min(...raw.indicator.map(p => p[1])), Math.max(...raw.indicator.map(p => p[1]))]
  put(diagram, 'path', { class: 'indicator', d: raw.indicator.map(([f, dB], k) =>
    `${k ? 'L' : 'M'}${x(f).toFixed(1)} ${(340 - 300 * (dB - least) / ((most - least) || 1)).toFixed(1)}`).join('') })
  for (const kind of [0, 1, 2])
    put(diagram, 'path', { class: `kind${kind}`, d: [...poles.kind.keys()].filter(k => poles.kind[k] === kind)
      .map(k => marks[kind](+x(poles.frequency[k]).toFixed(1), +y(poles.order[k]).toFixed(1))).join('') })
  const over = put(diagram, 'g')
  const ring = put(diagram, 'circle', { r: 8, class: 'cursor', visibility: 'hidden' })

  function drawChosen() {
    over.replaceChildren()
    chosen.forEach(({ pole }, number) => {
      put(over, 'path', { class: 'chosen', d: `M${x(pole[0])} 24V340` })
      put(over, 'path', { class: 'diamond', d: `M${x(pole[0])} 17l6 6l-6 6l-6 -6z` })
      put(over, 'text', { x: x(pole[0]), y: 13, 'text-anchor': 'middle' }, number + 1)
    })
  }
  function move(to) {
    cursor = to
    ring.setAttribute('cx', x(poles.frequency[to]))
    ring.setAttribute('cy', y(poles.order[to]))
    ring.setAttribute('visibility', 'visible')
  }
  diagram.addEventListener('click', event => {
    const box = diagram.getBoundingClientRect(), scale = WIDE / box.width
    const [u, v] = [(event.clientX - box.left) * scale, (event.clientY - box.top) * scale]
    const away = k => Math.hypot(x(poles.frequency[k]) - u, y(poles.order[k]) - v)
    const close = [...poles.kind.keys()].filter(k => poles.kind[k] > 0 && away(k) < 14)
      .sort((a, b) => away(a) - away(b))[0]
    const mark = chosen.findIndex(({ pole }) => Math.abs(x(pole[0]) - u) < 8 && v < 25)
    if (mark >= 0) return drop(mark)
    if (close === undefined) return refresh('no stable pole there')
    move(close)
    return toggle(close)
  })
  diagram.addEventListener('keydown', event => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key], rise = { ArrowUp: 1, ArrowDown: -1 }[event.key]
    if (!stable.length || !(step || rise || event.key === 'Enter' || event.key === ' ')) return
    event.preventDefault()
    if (cursor < 0) move(stable[0])
    else if (step) {
      const far = k => step * (poles.frequency[k] - poles.frequency[cursor]) > 0.005 * poles.frequency[cursor]
      const next = (step > 0 ? stable : [...stable].reverse()).find(far)
      if (next !== undefined) move(next)
    } else if (rise) {
      const here = k => rise * (poles.order[k] - poles.order[cursor]) > 0 &&
        Math.abs(poles.frequency[k] / poles.frequency[cursor] - 1) < 0.01
      const next = stable.filter(here).sort((a, b) => rise * (poles.order[a] - poles.order[b]))[0]
      if (next !== undefined) move(next)
    } else return toggle(cursor)
    said.textContent = `${describe(cursor)}, ${near(cursor) >= 0 ? 'chosen' : 'not chosen'}`
  })
  function drop(number) {
    const [{ pole }] = chosen.splice(number, 1)
    refresh(`dropped ${digits(pole[0], 6)} Hz`)
  }

  const thinned = value => { // the lowest and the highest line of each bin
    const count = data.omega.length, size = k => value[k] ** 2 + value[count + k] ** 2
    if (count <= 2 * DRAWN) return [...Array(count).keys()]
    const kept = []
    for (let bin = 0; bin < DRAWN; bin++) {
      const lines = []
      for (let k = Math.floor(bin * count / DRAWN); k < Math.floor((bin + 1) * count / DRAWN); k++) lines.push(k)
      const by = lines.sort((a, b) => size(a) - size(b))
      kept.push(...[by[0], by[by.length - 1]].sort((a, b) => a - b))
    }
    return [...new Set(kept)]
  }
  function draw() {
    curves.replaceChildren()
    const count = data.omega.length, value = data.value[shown], lines = thinned(value)
    const level = (part, k) => 10 * Math.log10(Math.max(part[k] ** 2 + part[count + k] ** 2, 1e-300))
    const levels = lines.map(k => level(value, k))
    const [floor, top] = [Math.min(...levels), Math.max(...levels)].map((dB, k) => dB + (k ? 3 : -3))
    const v = dB => Math.min(Math.max(240 - 225 * (dB - floor) / (top - floor), 5), 250)
    axis(curves, 250, 10)
    for (let dB = Math.ceil(floor / 20) * 20; dB <= top; dB += 20)
      put(curves, 'text', { x: LEFT - 8, y: v(dB) + 4, 'text-anchor': 'end' }, dB)
    put(curves, 'text', { x: 14, y: 130, transform: 'rotate(-90 14 130)', 'text-anchor': 'middle' },
      `|${raw.form}| [dB re ${raw.unit}]`)
    const phase = (part, k) => 180 / Math.PI * Math.atan2(part[count + k], part[k])
    put(curves, 'text', { x: 14, y: 335, transform: 'rotate(-90 14 335)', 'text-anchor': 'middle' }, 'Phase [°]')
    for (const degrees of [-180, 0, 180])
      put(curves, 'text', { x: LEFT - 8, y: 339 - degrees / 4, 'text-anchor': 'end' }, degrees)
    put(curves, 'path', { class: 'axis', d: `M${LEFT} 287V385H${WIDE - RIGHT}` })
    put(curves, 'text', { x: (LEFT + WIDE) / 2, y: 398, 'text-anchor': 'middle' }, 'Frequency [Hz]')
    const line = (part, at) => lines.map((k, n) =>
      `${n ? 'L' : 'M'}${x(data.frequency[k]).toFixed(1)} ${at(part, k).toFixed(1)}`).join('')
    const angle = (part) => {
      let path = '', before = null
      for (const k of lines) { // a jump by a turn is no line
        const now = phase(part, k)
        path += `${before === null || Math.abs(now - before) > 180 ? 'M' : 'L'}` +
          `${x(data.frequency[k]).toFixed(1)} ${(335 - now / 4).toFixed(1)}`
        before = now
      }
      return path
    }
    const both = [['measured', value], ['synthesised', answer && chosen.length ? answer.frfs[shown].model : null]]
    for (const [look, part] of both) {
      if (!part) continue
      put(curves, 'path', { class: look, d: line(part, (one, k) => v(level(one, k))) })
      put(curves, 'path', { class: look, d: angle(part) })
    }
    const misfit = answer ? `; deviation ${digits(100 * answer.misfit, 3)} % of all FRFs` : ''
    curves.setAttribute('aria-label', `Measured and synthesised ${raw.labels[shown]}, ${chosen.length} modes${misfit}`)
  }
  function rows() {
    body.replaceChildren()
    chosen.forEach(({ pole, from }, number) => {
      const row = put(body, 'tr')
      const sizes = answer ? answer.frfs.map(one => Math.hypot(...one.residue[number])) : [NaN]
      const cells = [number + 1, digits(pole[0], 7), digits(100 * pole[1], 4), digits(Math.max(...sizes), 4), from]
      cells.forEach((cell, k) => put(row, 'td', { class: k < 4 ? 'n' : 'w' }, cell))
      const one = button(put(row, 'td'), 'drop', () => { drop(number); diagram.focus() })
      one.setAttribute('aria-label', `drop the mode at ${digits(pole[0], 6)} Hz`)
    })
  }
  function refresh(why) {
    answer = fitted(data, chosen.map(({ pole }) => pole))
    drawChosen()
    draw()
    rows()
    for (const [k, box] of boxes) box.checked = beside(k) >= 0
    const misfit = answer ? `what is synthesised deviates by ${digits(100 * answer.misfit, 3)} % (root mean square)` : ''
    said.textContent = `${why ? `${why}; ` : ''}${chosen.length} mode${chosen.length === 1 ? '' : 's'} chosen; ${misfit}`
    changed()
  }
  root.flexmodal = {
    chosen: () => chosen.map(({ pole }) => pole),
    fit: () => answer && answer.frfs.map(({ residue, rest }) => ({ residue, rest })),
    misfit: () => answer && answer.misfit,
    place: k => [x(poles.frequency[k]) / WIDE, y(poles.order[k]) / 380],
    stable: () => stable.map(k => [k, ...poleOf(k)]),
    raw,
  }
  refresh('')
}

// ---- The file ----

const float = value => Number.isInteger(value) ? value.toFixed(1) : String(value)
const choice = (all, panels) => {
  const lines = ['# Modes chosen in the page of a fit; repeat it with: flexmodal fit FILE --choice THIS_FILE',
    'format = 1', `title = ${JSON.stringify(all.title)}`, `residuals = "${all.residuals}"`,
    `band = [${all.band.map(float).join(', ')}]`]
  for (const { flexmodal } of panels) {
    if (!flexmodal.chosen().length) continue
    lines.push('', '[[posture]]', `id = ${flexmodal.raw.posture}`,
      `fingerprint = [${flexmodal.raw.fingerprint.map(float).join(', ')}]`)
    for (const [frequency, damping] of flexmodal.chosen())
      lines.push('', '[[posture.mode]]', `frequency = ${float(frequency)}`, `damping_ratio = ${float(damping)}`)
  }
  return `${lines.join('\n')}\n`
}

for (const root of document.querySelectorAll('[data-live="choose"]')) {
  const all = JSON.parse(root.nextElementSibling.textContent)
  const panels = all.postures.map(() => put(root, 'div', { class: 'posture' }))
  const saving = put(root, 'div', { class: 'tools' })
  const save = put(saving, 'button', { type: 'button', class: 'save' }, 'Save the choice: choice.toml')
  const note = put(root, 'p', { class: 'note' })
  const changed = () => {
    const empty = all.postures.filter((_, k) => panels[k].flexmodal && !panels[k].flexmodal.chosen().length)
    save.disabled = empty.length === all.postures.length
    note.textContent = 'Then: flexmodal fit FILE --choice choice.toml' +
      (empty.length ? `. Postures without a chosen mode are left out: ${empty.map(p => p.name).join('; ')}` : '')
  }
  all.postures.forEach((raw, k) => panel(panels[k], { ...raw, residuals: all.residuals, apart: all.apart }, changed))
  root.choice = () => choice(all, panels)
  save.addEventListener('click', () => {
    const address = URL.createObjectURL(new Blob([root.choice()], { type: 'application/toml' }))
    const link = document.createElement('a')
    link.href = address
    link.download = 'choice.toml'
    link.click()
    setTimeout(() => URL.revokeObjectURL(address), 1000)
  })
  changed()
}
})()
