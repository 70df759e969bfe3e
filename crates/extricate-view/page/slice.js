// The slice: the plane through the query and its exits.

// Of free cells, of those that collide, of those beyond the limits; ink and paper of lines and labels.
const SLICE_LIGHT = { f: [240, 246, 252], c: [240, 190, 155], o: [205, 209, 216], ink: "#1b2430", paper: "#ffffff", exit: "#00659e", other: "#55606e" };
const SLICE_DARK = { f: [38, 50, 64], c: [122, 62, 22], o: [78, 84, 93], ink: "#e6eaf0", paper: "#12161c", exit: "#6cbcf0", other: "#a3adba" };

function sliceColours() {
    return COLOURS === DARK ? SLICE_DARK : SLICE_LIGHT;
}

function cellsOf({ states, cells }) {
    const [image, colours] = [new ImageData(cells, cells), sliceColours()];
    let at = 0;
    for (const [, state, count] of states.matchAll(/([fco])(\d*)/g)) {
        for (let k = Number(count || 1); k > 0; k--, at++) {
            const row = cells - 1 - Math.floor(at / cells);
            image.data.set([...colours[state], 255], 4 * (row * cells + at % cells));
        }
    }
    return image;
}

// The cells of the slice that was drawn last, in its colours.
const drawnCells = {};

function drawCells(context, slice, size) {
    if (drawnCells.slice !== slice || drawnCells.colours !== sliceColours()) {
        const image = element("canvas", { width: slice.cells, height: slice.cells });
        image.getContext("2d", { willReadFrequently: true }).putImageData(cellsOf(slice), 0, 0);
        Object.assign(drawnCells, { slice, colours: sliceColours(), image });
    }
    context.imageSmoothingEnabled = false;
    context.drawImage(drawnCells.image, 0, 0, size, size);
}

function drawRing(context, points, at, dash, width) {
    if (!points.length) return;
    context.beginPath();
    points.forEach((point, k) => (k ? context.lineTo(...at(point)) : context.moveTo(...at(point))));
    context.closePath();
    context.setLineDash(dash);
    context.lineWidth = width;
    context.strokeStyle = sliceColours().ink;
    context.stroke();
    context.setLineDash([]);
}

function label(context, text, [x, y], ink) {
    context.font = `600 ${context.canvas.width / 26}px system-ui, sans-serif`;
    context.lineWidth = 4;
    context.strokeStyle = sliceColours().paper;
    context.strokeText(text, x, y);
    context.fillStyle = ink;
    context.fillText(text, x, y);
}

// A length that is written beside a bar of it: 1, 2 or 5 times a power of ten.
function niceLength(most) {
    const power = 10 ** Math.floor(Math.log10(most));
    return [5, 2, 1].map(k => k * power).find(length => length <= most);
}

function drawScale(context, slice, size, unit) {
    const length = niceLength(0.6 * slice.half);
    const pixels = length / slice.half * size / 2;
    const y = size * 0.955;
    context.fillStyle = sliceColours().ink;
    context.fillRect(size * 0.04, y, pixels, 3);
    label(context, `${length}${unit}`, [size * 0.04, y - 8], sliceColours().ink);
}

// Draws the slice of `answer`, with a point at `fraction` of the exit `chosen`.
function drawSlice(canvas, slice, chosen, fraction, unit) {
    const size = canvas.width;
    const context = canvas.getContext("2d");
    const at = ([x, y]) => [(x / slice.half + 1) * size / 2, (1 - y / slice.half) * size / 2];
    drawCells(context, slice, size);
    drawRing(context, slice.rings[1], at, [7, 7], 1.5);
    drawRing(context, slice.rings[0], at, [], 3);
    const centre = at([0, 0]);
    slice.exits.forEach((exit, k) => {
        if (k >= slice.in_plane && k !== chosen) return;
        const [isChosen, end] = [k === chosen, at(exit)];
        context.strokeStyle = context.fillStyle = isChosen ? sliceColours().exit : sliceColours().other;
        context.lineWidth = isChosen ? 3 : 1.5;
        context.setLineDash(k < slice.in_plane ? [] : [3, 6]);
        context.beginPath();
        context.moveTo(...centre);
        context.lineTo(...end);
        context.stroke();
        context.setLineDash([]);
        context.beginPath();
        context.arc(...end, size / 75, 0, 7);
        context.fill();
        label(context, String(k + 1), [end[0] + size / 50, end[1] - size / 60], context.fillStyle);
    });
    context.fillStyle = "#c24e00";
    context.fillRect(centre[0] - size / 80, centre[1] - size / 80, size / 40, size / 40);
    const point = at(slice.exits[chosen].map(x => x * fraction));
    context.beginPath();
    context.arc(...point, size / 60, 0, 7);
    context.fillStyle = sliceColours().ink;
    context.fill();
    context.lineWidth = 3;
    context.strokeStyle = sliceColours().paper;
    context.stroke();
    drawScale(context, slice, size, unit);
}

// What the slice shows, in words.
function captionOf(slice, chosen, hasProof) {
    const plane = slice.in_plane === 2
        ? "The plane through the query and exits 1 and 2."
        : `The plane through the query, exit 1 and the direction of ${slice.up}.`;
    const seen = chosen < slice.in_plane ? "" : ` Exit ${chosen + 1} lies outside of it, and is shown as seen from above.`;
    const ring = hasProof
        ? " Inside the solid line nothing is free: proved." : " Nothing is proved here.";
    return `${plane} Each of its ${slice.cells} \u00d7 ${slice.cells} cells was checked exactly: orange collides, `
        + `grey is outside the limits, the rest is free. Square: the query. Dot: where the slider is.${ring} `
        + `Dashed line: as far as exit 1.${seen}`;
}
