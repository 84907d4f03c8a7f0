// SPDX-License-Identifier: Apache-2.0
// node-canopen (npm: canopen) with its own time-outs, of which that of an SDO transfer is 30 ms. Argument: HOST:PORT of an
// SLCAN adapter. Prints a JSON object for each step, as python_canopen.py does.
'use strict';

const Module = require('module');
const net = require('net');

// Native code that computes the CRC of block transfers, which are not used here.
const load = Module._load;
Module._load = (name, ...rest) => (name === 'node-crc' ? {} : load(name, ...rest));
const { Device, DataType } = require('canopen');

const NODE_ID = 1;
const OWN_ID = 0x7D;
const { UNSIGNED32, UNSIGNED16, INTEGER8, INTEGER16 } = DataType;
const FAULT = 0x08;
const ENABLED = 0x27;
const SWITCH_ON_DISABLED = 0x40;
const PROFILE_VELOCITY = 3;

const device = new Device({ id: OWN_ID });

function join(address) {
    const [host, port] = address.split(':');
    const socket = net.connect(Number(port), host).setNoDelay(true);
    let rest = '';
    socket.on('data', (bytes) => {
        const lines = (rest + bytes.toString('ascii')).split('\r');
        rest = lines.pop();
        for (const line of lines.filter((text) => text[0] === 't')) {
            const data = Buffer.from(line.slice(5, 5 + 2 * parseInt(line[4], 16)), 'hex');
            device.receive({ id: parseInt(line.slice(1, 4), 16), data, len: data.length });
        }
    });
    device.addListener('message', ({ id, data }) => {
        socket.write(`t${id.toString(16).padStart(3, '0')}${data.length}${data.toString('hex')}\r`);
    });
    socket.write('C\rS8\rO\r');
    return socket;
}

const sleep = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
const get = (index, subIndex, dataType) => device.sdo.upload({ deviceId: NODE_ID, index, subIndex, dataType });
const set = (index, subIndex, data, dataType, options = {}) =>
    device.sdo.download({ deviceId: NODE_ID, index, subIndex, data, dataType, ...options });

function check(condition, text) {
    if (!condition)
        throw new Error(text);
}

async function resetNode() {
    device.nmt.resetNode(NODE_ID);
    await sleep(1000);
}

async function command(controlword, mask, state) {
    await set(0x6040, 0, controlword, UNSIGNED16);
    for (let i = 0; i < 100 && (await get(0x6041, 0, UNSIGNED16) & mask) !== state; i++)
        await sleep(10);
    const statusword = await get(0x6041, 0, UNSIGNED16);
    check((statusword & mask) === state, `statusword ${statusword.toString(16)} after ${controlword.toString(16)}`);
}

const steps = {
    // 30 ms are less than a flash needs. What timed out is stored all the same, and the next save answers at once.
    async store_that_times_out() {
        await set(0x607F, 0, 654321, UNSIGNED32);
        const text = await set(0x1010, 1, Buffer.from('save')).then(() => 'timed out', (error) => error.message);
        check(/timed out/.test(text), text);
        await sleep(500);
        await set(0x1010, 1, Buffer.from('save'));
        await resetNode();
        check(await get(0x607F, 0, UNSIGNED32) === 654321, 'not stored');
    },
    async store_with_a_time_out_of_1_s() {
        await set(0x607F, 0, 600000, UNSIGNED32);
        await set(0x1010, 1, Buffer.from('save'), null, { timeout: 1000 });
        await resetNode();
        check(await get(0x607F, 0, UNSIGNED32) === 600000, 'not stored');
    },
    async restore() {
        await set(0x1011, 1, Buffer.from('load'));
        await resetNode();
        check(await get(0x607F, 0, UNSIGNED32) === 1000000, 'not restored');
    },
    async enable() {
        device.nmt.startNode(NODE_ID);
        await set(0x6007, 0, 0, INTEGER16);
        await set(0x6060, 0, PROFILE_VELOCITY, INTEGER8);
        await command(0x06, 0x6F, 0x21);
        await command(0x07, 0x6F, 0x23);
        await command(0x0F, 0x6F, ENABLED);
    },
    async get_a_fault() {
        device.nmt.stopNode(NODE_ID);
        await sleep(300);
        device.nmt.startNode(NODE_ID);
        await command(0x00, 0x4F, FAULT);
    },
    async reset_the_fault() {
        await command(0x80, 0x4F, SWITCH_ON_DISABLED);
        await steps.enable();
        await command(0x00, 0x4F, SWITCH_ON_DISABLED);
    },
};

async function ticksMs() {
    return get(0x3010, 1, UNSIGNED32);
}

async function take(name) {
    const seen = { step: name, error: null, pace: 0 };
    const beganMs = performance.now();
    try {
        await steps[name]();
    }
    catch (error) {
        seen.error = error.message;
    }
    try {
        const nodeMs = await ticksMs();
        const before = performance.now();
        await sleep(200);
        seen.pace = (await ticksMs() - nodeMs) / (performance.now() - before);
    }
    catch { /* slower than node-canopen waits */ }
    seen.took_ms = Math.round(performance.now() - beganMs);
    console.log(JSON.stringify(seen));
    return seen.error === null;
}

async function main(address) {
    const socket = join(address);
    device.eds.addSdoClientParameter(NODE_ID, 0x600 + NODE_ID, 0x580 + NODE_ID);
    device.start();
    await sleep(300);
    let good = true;
    for (const name of Object.keys(steps))
        good = good && await take(name);
    device.stop();
    socket.destroy();
    process.exit(good ? 0 : 1);
}

main(process.argv[2]);
