// SPDX-License-Identifier: Apache-2.0
// Timers of a hidden page are slowed down, those of a worker are not: the page that commands says so with each of these.
setInterval(() => postMessage(0), 100);
