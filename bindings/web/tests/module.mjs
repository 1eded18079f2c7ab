// Drives the module without a page: makes the calls that examples/drive.rs writes, and compares the digests.
import { readFileSync } from "node:fs";

const { instance } = await WebAssembly.instantiate(readFileSync(process.argv[2]), {});
const core = instance.exports;
const bits = new DataView(new ArrayBuffer(8));
const real = (word) => {
  bits.setBigUint64(0, BigInt("0x" + word));
  return bits.getFloat64(0);
};
const put = (numbers) => new Float64Array(core.memory.buffer, core.input(), numbers.length).set(numbers);
const calls = {
  describe: (...numbers) => (put(numbers), core.describe()),
  predict: core.predict,
  scan: (sensor, ...numbers) => (put(numbers), core.scan(sensor, numbers.length / 2)),
  position: core.observe_position,
  heading: core.observe_heading,
};
let compared = 0;
for (const line of readFileSync(0, "utf8").trim().split("\n")) {
  const [call, ...words] = line.split(" ");
  if (call !== "digest") {
    if (calls[call](...words.map(real)) !== 0) throw new Error("the module refuses " + call);
  } else if (BigInt.asUintN(64, core.digest()) === BigInt("0x" + words[0])) compared++;
  else throw new Error("another digest, after " + compared + " equal ones");
}
console.log(compared + " digests of described filters in the module are those of the library");
