// Tables that come with the page, as web/tools/build.mjs has made them.

import type { StoredTable } from "../core/stored";

declare const __STORED__: StoredTable[];

export const STORED: readonly StoredTable[] = __STORED__;
