// Live changes of a running simulation, by the keys of `cardsflow run --set` where such keys exist.

class Changes {
  constructor(engine) {
    this.engine = engine;
    this.all = {};
  }
  write() {}
  replace(all) { this.all = all; }
}
