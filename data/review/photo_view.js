// A photo's scan with what was found on it: marks, patches, ties by state, and what was said.
'use strict';

// Tiles of a raster of the server; map units are its pixels, (col, row) = (lng, -lat).
function rasterTiles(address, size) {
  const layer = L.tileLayer('', {
    tileSize: 256,
    minNativeZoom: 1 - size.levels,
    maxNativeZoom: 0,
    minZoom: 1 - size.levels,
    maxZoom: 5,
    noWrap: true,
    bounds: rasterBounds(size),
  });
  // Tiles at the edge are smaller; Leaflet would stretch them.
  layer.on('tileload', ({tile}) => {
    const scale = parseFloat(tile.style.width) / 256;
    tile.style.width = scale * tile.naturalWidth + 'px';
    tile.style.height = scale * tile.naturalHeight + 'px';
  });
  layer.getTileUrl = (place) => address + '/' + (-place.z) + '/' + place.x + '/' + place.y;
  return layer;
}

function rasterBounds(size) {
  return L.latLngBounds([-size.height, 0], [0, size.width]);
}

const STATE_COLOURS = {
  used: '#35c24a', matched: '#35c24a', rejected: '#ff9b1a', not_found: '#b8bcc2', missing: '#ff5a4f',
};

// 1, 2 or 5 times a power of ten: most of the residuals that count become short, visible lines.
function exaggerationOf(found, width) {
  const lengths = found.filter((one) => one.residual_px && one.state !== 'rejected')
      .map((one) => Math.hypot(...one.residual_px)).sort((a, b) => a - b);
  const most = lengths[Math.floor(0.9 * lengths.length)];
  if (!(most > 1e-6)) return 1;  // as many observations as unknowns: residuals are rounding
  const wanted = 0.05 * width / most;
  const power = 10 ** Math.floor(Math.log10(wanted));
  return Math.max(1, [5, 2, 1].find((step) => step * power <= wanted) * power);
}

class PhotoView {
  constructor(container, clicked) {
    this.map = L.map(container, {
      crs: L.CRS.Simple, minZoom: -10, maxZoom: 5, attributionControl: false, preferCanvas: true,
      keyboard: false, zoomAnimation: false, fadeAnimation: false, markerZoomAnimation: false,
    });
    this.map.setView([0, 0], 0);
    this.map.on('click', (event) => clicked(this.pixelOf(event.latlng)));
    this.layers = {};
    for (const name of ['Frame', 'Marks', 'Patches', 'Ties', 'Said']) {
      this.layers[name] = L.layerGroup().addTo(this.map);
    }
    L.control.layers(null, this.layers).addTo(this.map);
  }

  pixelOf(place) { return [place.lng, -place.lat]; }
  placeOf(pixel) { return [-pixel[1], pixel[0]]; }
  centre() { return this.pixelOf(this.map.getCenter()); }

  // Stays where the person looks where it is the photo that was shown.
  show(photo) {
    const same = this.name === photo.name;
    this.name = photo.name;
    if (!same && this.tiles) {
      this.tiles.remove();
      this.tiles = null;
    }
    if (!same && photo.scan) {
      this.tiles = rasterTiles('tile/' + encodeURIComponent(photo.name), photo.scan);
      this.tiles.addTo(this.map);
      this.map.fitBounds(rasterBounds(photo.scan));
    }
    Object.values(this.layers).forEach((layer) => layer.clearLayers());
    return this.draw(photo);
  }

  draw(photo) {
    const marks = photo.interior ? photo.interior.marks : [];
    const patches = photo.exterior ? photo.exterior.patches : [];
    const width = photo.scan ? photo.scan.width : 1000;
    const times = {
      marks: exaggerationOf(marks, width),
      patches: exaggerationOf(patches, width),
      ties: exaggerationOf(photo.ties, width),
    };
    if (photo.interior) this.expect(photo.interior);
    for (const mark of marks) this.dot('Marks', mark, 'mark ' + mark.id, 9, times.marks);
    for (const patch of patches) {
      this.dot('Patches', patch, 'patch ' + patch.id, 5, times.patches);
    }
    for (const tie of photo.ties) this.dot('Ties', tie, 'tie ' + tie.id, 3, times.ties);
    for (const said of photo.said.marks) this.cross(said.pixel, 'said: mark ' + said.mark);
    for (const said of photo.said.points) this.cross(said.pixel, 'said: point ' + said.point);
    return times;
  }

  // The frame, and windows where marks are expected and none was found.
  expect(interior) {
    const style = {color: '#ff5a4f', weight: 1.5, fill: false};
    if (interior.frame.length) {
      L.polygon(interior.frame.map((corner) => this.placeOf(corner)),
          {...style, color: '#8fb8ff', dashArray: '6 4', interactive: false})
          .addTo(this.layers.Frame);
    }
    const found = new Set(interior.marks.filter((mark) => mark.pixel).map((mark) => mark.id));
    const reach = interior.pixel_size_um ? 3000 / interior.pixel_size_um : 60;
    for (const mark of interior.expected.filter((one) => !found.has(one.id))) {
      const [col, row] = mark.pixel;
      L.rectangle([[-row - reach, col - reach], [-row + reach, col + reach]], style)
          .bindTooltip(element('span', 'mark ' + mark.id + ' is expected here'))
          .addTo(this.layers.Frame);
    }
  }

  dot(layer, found, name, radius, times) {
    const pixel = found.pixel || found.predicted;
    if (!pixel) return;
    const colour = STATE_COLOURS[found.state] || '#6cb3ff';
    const text = [name, found.state, found.reason].filter(Boolean).join(', ');
    L.circleMarker(this.placeOf(pixel), {radius, color: colour, weight: 2, fillOpacity: 0})
        .bindTooltip(element('span', text)).addTo(this.layers[layer]);
    if (!found.residual_px) return;
    const end = [0, 1].map((i) => pixel[i] + times * found.residual_px[i]);
    L.polyline([this.placeOf(pixel), this.placeOf(end)], {color: colour, weight: 2})
        .addTo(this.layers[layer]);
  }

  // A mark measured at a click, until the photo is shown anew.
  seen(pixel, text) {
    const reach = 8;
    const place = (dx, dy) => this.placeOf([pixel[0] + dx, pixel[1] + dy]);
    L.polyline([[place(-reach, 0), place(reach, 0)], [place(0, -reach), place(0, reach)]],
        {color: '#35c24a', weight: 2}).bindTooltip(element('span', text)).addTo(this.layers.Said);
  }

  cross(pixel, text) {
    if (!pixel) return;
    L.circleMarker(this.placeOf(pixel), {radius: 7, color: '#ff3df2', weight: 2, fillOpacity: 0.15})
        .bindTooltip(element('span', text), {permanent: true, direction: 'right'})
        .addTo(this.layers.Said);
  }
}
