// The core in Node, for tools and tests: the smallest caller of crates/web.

export async function openCore(bytes) {
  const { instance } = await WebAssembly.instantiate(bytes, {});
  const e = instance.exports;
  e.begin();
  const words = (place, length) => Buffer.from(e.memory.buffer, place(), length()).toString("utf8");
  const call = (name, text = "", numbers = []) => {
    const bytes = Buffer.from(text, "utf8");
    const place = e.text(bytes.length);
    const values = e.numbers(numbers.length);
    new Uint8Array(e.memory.buffer, place, bytes.length).set(bytes);
    new Float64Array(e.memory.buffer, values, numbers.length).set(numbers);
    let failed;
    try {
      failed = e[name]();
    } catch (error) {
      throw new Error(`trap: ${words(e.panic_message, e.panic_length)} (${error.message})`);
    }
    const message = words(e.message, e.message_length);
    if (failed) throw new Error(message);
    return { result: new Float64Array(e.memory.buffer, e.result(), e.result_length()).slice(), message };
  };
  return { call, exports: e };
}
