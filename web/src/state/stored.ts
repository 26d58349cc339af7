// Tables that come with the page (web/tools/build.mjs makes them), by the key of their request.

export const STORED = new Map<string, string>(__STORED__);

declare const __STORED__: [string, string][];
