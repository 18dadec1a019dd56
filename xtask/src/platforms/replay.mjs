// Plays recordings by the C interface of a module without any system: node replay.mjs MODULE RECORDING ...
import { readFileSync } from 'node:fs';

const [module, ...recordings] = process.argv.slice(2);
const { instance } = await WebAssembly.instantiate(readFileSync(module), {});
const { memory, ls_recording_replay, ls_last_error_message_get } = instance.exports;

const PAGE = 65536, REPORT = 112, ALL = 0xffffffffffffffffn;
const contents = recordings.map(path => readFileSync(path));
const longest = Math.max(...contents.map(content => content.length));
// Pages that the module has not asked for are nobody else's.
const report = memory.grow(Math.ceil(longest / PAGE) + 1) * PAGE, recording = report + PAGE;

const text = at => {
    const bytes = new Uint8Array(memory.buffer, at);
    return new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
};
let failed = 0;
recordings.forEach((path, number) => {
    const content = contents[number];
    new Uint8Array(memory.buffer, recording, content.length).set(content);
    const result = ls_recording_replay(recording, content.length, ALL, 0, report, REPORT);
    // calls, refused, steps: uint64; diverged, cut_short: uint32
    const view = new DataView(memory.buffer, report, REPORT);
    const steps = Number(view.getBigUint64(16, true)), differs = view.getUint32(24, true) + view.getUint32(28, true);
    if (result !== 0 || differs !== 0 || steps === 0) {
        console.log(`${path}: result ${result} ${result ? text(ls_last_error_message_get()) : ''}, ${steps} steps, differs ${differs}`);
        failed += 1;
    }
});
console.log(`${recordings.length} recordings, ${failed} of them come out otherwise`);
process.exit(failed || recordings.length === 0 ? 1 : 0);
