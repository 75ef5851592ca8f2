// node validate_glb.mjs FILE: what the validator of the Khronos group says of it, as JSON.
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';

const require = createRequire(new URL('../../clients/web/package.json', import.meta.url));
const validator = require('gltf-validator');
const report = await validator.validateBytes(new Uint8Array(readFileSync(process.argv[2])));
console.log(JSON.stringify(report));
