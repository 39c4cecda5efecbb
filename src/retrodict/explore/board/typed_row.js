// A quantity that is typed. What stands in the field is the browser's: it is sent whole by Enter or by
// leaving the field, and the server writes over nothing that it has not been sent yet.
export default {
  template: `
    <div class="typed">
      <div class="label">{{ label }}</div>
      <input class="field" type="text" v-model="text" :aria-label="label" :aria-invalid="!!fault" :placeholder="example"
        autocomplete="off" spellcheck="false" @keydown.enter="entered" @blur="left">
      <div class="small" :title="whole">{{ note }}</div>
      <div class="fault" role="alert">{{ fault }}</div>
    </div>`,
  props: { label: String, example: String, note: String, whole: String, state: Object },
  data() {
    return { text: this.state.text, was: this.state.text, sent: null, number: this.state.done };
  },
  computed: {
    typed() { return this.text.trim(); },
    fault() {
      const refused = this.state.refused;
      return refused && refused.text === this.typed ? refused.why : "";
    },
  },
  watch: {
    state(next) {
      const waiting = this.number > next.done; // for the answer to what was sent last
      const unsent = this.typed !== this.was.trim() && this.typed !== this.sent;
      const refused = next.refused && next.refused.text === this.typed;
      this.was = next.text;
      if (waiting || unsent || refused) return;
      this.text = next.text;
      this.sent = null;
    },
  },
  methods: {
    entered(event) {
      if (!event.isComposing) this.send();
    },
    left() {
      if (this.typed !== this.sent) this.send();
    },
    send() {
      if (this.typed === this.was.trim() && this.number <= this.state.done) return;
      this.sent = this.typed;
      this.$emit("typed", { text: this.typed, number: ++this.number });
    },
  },
};
