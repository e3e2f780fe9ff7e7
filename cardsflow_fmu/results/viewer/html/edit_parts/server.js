// Requests to the server of `cardsflow edit`. Without a server, the page draws straight muscles and offers files.

class EditServer {
  constructor(token) {
    this.token = token;
    this.next = null;
    this.isBusy = false;
    this.onresult = () => {};
  }

  get exists() { return this.token !== null; }

  // Evaluates a document at a pose. One request is sent at a time; of those that wait, only the newest is sent.
  async evaluate(document_, pose) {
    if (!this.exists) return;
    this.next = { document: document_, pose };
    if (this.isBusy) return;
    this.isBusy = true;
    while (this.next) {
      const body = this.next;
      this.next = null;
      this.onresult(await this.post("evaluate", body).catch(error => ({ error: error.message })));
    }
    this.isBusy = false;
  }

  save(body) { return this.post("save", body); }

  async post(path, body) {
    let answer;
    try {
      answer = await fetch(path, {
        method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify({ ...body, token: this.token }) });
    } catch {
      throw new Error("the server does not answer; is `cardsflow edit` still running?");
    }
    if (!answer.ok) throw new Error(`the server reports: ${answer.status} ${answer.statusText}`);
    return answer.json();
  }
}
