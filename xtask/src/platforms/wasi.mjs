// Runs a WASI program under node: node wasi.mjs MODULE ARGUMENT ...
import { readFile } from 'node:fs/promises';
import { WASI } from 'node:wasi';

const [module, ...words] = process.argv.slice(2);
const wasi = new WASI({ version: 'preview1', args: [module, ...words], preopens: { '/': '/' }, returnOnExit: true });
const compiled = await WebAssembly.compile(await readFile(module));
// Functions that an old C library lacks; nothing calls them.
const missing = {};
for (const { module: from, name } of WebAssembly.Module.imports(compiled))
    if (from === 'env')
        missing[name] = () => { throw new Error(`${name} is not there`); };
process.exit(wasi.start(await WebAssembly.instantiate(compiled, { ...wasi.getImportObject(), env: missing })));
