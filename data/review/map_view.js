// The block from above: footprints and projection centres by state, ground points, an orthophoto.
'use strict';

const STATUS_COLOURS = {ok: '#2a7d34', weak: '#b36b00', failed: '#b3261e'};

const HANDLE = L.divIcon({className: 'handle', iconSize: [18, 18]});

class MapView {
  // `placed`: a photo's handle was dragged to a place of the ground. `busy`: whether a click means
  // the ground; there is no handle in its way then.
  constructor(container, clicked, chosen, placed, busy) {
    this.map = L.map(container, {
      crs: L.CRS.Simple, minZoom: -20, maxZoom: 6, attributionControl: false, preferCanvas: true,
      keyboard: false, zoomAnimation: false, fadeAnimation: false, markerZoomAnimation: false,
    });
    this.map.setView([0, 0], 0);
    this.map.on('click', (event) => clicked(this.groundOf(event.latlng)));
    this.chosen = chosen;
    this.placed = placed;
    this.busy = busy;
    this.patches = L.layerGroup().addTo(this.map);
    this.drawn = L.layerGroup().addTo(this.map);
    this.grid = null;  // from ground to map units
  }

  placeOf(ground) {
    return [(ground[1] - this.grid.y0) / this.grid.step_y,
      (ground[0] - this.grid.x0) / this.grid.step_x];
  }
  groundOf(place) {
    return this.grid && [this.grid.x0 + place.lng * this.grid.step_x,
      this.grid.y0 + place.lat * this.grid.step_y];
  }
  centre() { return this.groundOf(this.map.getCenter()); }

  show(map, current) {
    if (!this.grid) this.begin(map);
    this.drawn.clearLayers();
    this.handle = null;
    if (!this.grid) return;
    for (const photo of map.photos) this.drawPhoto(photo, photo.name === current);
    for (const point of map.points) {
      L.circleMarker(this.placeOf(point.ground), {radius: 5, color: '#a0159a', weight: 2})
          .bindTooltip(element('span', point.point + ', ' + point.role)).addTo(this.drawn);
    }
  }

  // Map units are the orthophoto's pixels, or metres from the first photo.
  begin(map) {
    const places = map.photos.flatMap((p) => p.footprint.length ? p.footprint :
      [p.centre || p.said_at || p.start]);
    if (map.ground) {
      this.grid = map.ground;
      rasterTiles('ground/ortho', map.ground).addTo(this.map);
    } else if (places.length) {
      this.grid = {x0: places[0][0], y0: places[0][1], step_x: 1, step_y: 1};
    }
    if (places.length) {
      this.map.fitBounds(L.latLngBounds(places.map((place) => this.placeOf(place))).pad(0.1));
    } else if (map.ground) {
      this.map.fitBounds(rasterBounds(map.ground));
    }
  }

  drawPhoto(photo, isCurrent) {
    const style = {color: STATUS_COLOURS[photo.status], weight: isCurrent ? 4 : 1.5,
      fillOpacity: isCurrent ? 0.15 : 0.03};
    const text = photo.name + ', ' + photo.status;
    // While a point is measured a click means the ground, whatever lies there.
    const choose = (event) => {
      if (this.chosen(photo.name)) L.DomEvent.stop(event);
    };
    if (photo.footprint.length) {
      L.polygon(photo.footprint.map((corner) => this.placeOf(corner)), style).addTo(this.drawn)
          .on('click', choose);
    }
    // Where a person says that it was taken, or where the run began or ended.
    const at = photo.said_at || photo.centre || photo.start;
    if (!photo.centre && at) {
      L.circleMarker(this.placeOf(at), {...style, radius: 6, fill: false, dashArray: '3 3'})
          .bindTooltip(element('span', text + ', roughly')).on('click', choose).addTo(this.drawn);
    }
    if (isCurrent && at) {
      this.handle = L.marker(this.placeOf(at), {icon: HANDLE, draggable: true, keyboard: false})
          .bindTooltip(element('span', 'drag it to where ' + photo.name + ' was taken'))
          .on('dragend', (event) =>
            this.placed(photo.name, this.groundOf(event.target.getLatLng())));
      this.showHandle();
    }
    if (photo.centre) {
      L.circleMarker(this.placeOf(photo.centre), {...style, radius: 6, fillOpacity: 0.6})
          .bindTooltip(element('span', text)).on('click', choose).addTo(this.drawn);
    }
  }

  // Where the patches of the photo that is shown lie on the ground, by state.
  showPatches(photo) {
    this.patches.clearLayers();
    if (!this.grid || !photo.exterior) return;
    for (const patch of photo.exterior.patches.filter((one) => one.ground)) {
      L.circleMarker(this.placeOf(patch.ground), {
        radius: 3, color: STATE_COLOURS[patch.state], weight: 1.5, fill: false, interactive: false,
      }).addTo(this.patches);
    }
  }

  showHandle() {
    if (!this.handle) return;
    if (this.busy()) this.handle.remove();
    else this.handle.addTo(this.drawn);
  }

  // A tenth of a footprint's longer side, the median one's: as well as a photo is placed by eye.
  roughly(map) {
    const sides = map.photos.filter((photo) => photo.footprint.length).map((photo) => {
      const range = (i) => Math.max(...photo.footprint.map((corner) => corner[i])) -
          Math.min(...photo.footprint.map((corner) => corner[i]));
      return Math.max(range(0), range(1));
    }).sort((a, b) => a - b);
    return sides.length ? Math.ceil(0.1 * sides[Math.floor(sides.length / 2)]) : 500;
  }
}
