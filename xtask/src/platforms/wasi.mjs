// Runs a WASI program under node: node wasi.mjs MODULE ARGUMENT ...
import { readFile } from 'node:fs/promises';
import { WASI } from 'node:wasi';

const [module, ...words] = process.argv.slice(2);
const wasi = new WASI({ version: 'preview1', args: [module, ...words], preopens: { '/': '/' }, returnOnExit: true });
const compiled = await WebAssembly.compile(await readFile(module));
process.exit(wasi.start(await WebAssembly.instantiate(compiled, wasi.getImportObject())));
