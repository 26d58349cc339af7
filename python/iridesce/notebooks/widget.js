var e = globalThis, t = e.ShadowRoot && (e.ShadyCSS === void 0 || e.ShadyCSS.nativeShadow) && "adoptedStyleSheets" in Document.prototype && "replace" in CSSStyleSheet.prototype, n = Symbol(), r = /* @__PURE__ */ new WeakMap(), i = class {
	constructor(e, t, r) {
		if (this._$cssResult$ = !0, r !== n) throw Error("CSSResult is not constructable. Use `unsafeCSS` or `css` instead.");
		this.cssText = e, this.t = t;
	}
	get styleSheet() {
		let e = this.o, n = this.t;
		if (t && e === void 0) {
			let t = n !== void 0 && n.length === 1;
			t && (e = r.get(n)), e === void 0 && ((this.o = e = new CSSStyleSheet()).replaceSync(this.cssText), t && r.set(n, e));
		}
		return e;
	}
	toString() {
		return this.cssText;
	}
}, a = (e) => new i(typeof e == "string" ? e : e + "", void 0, n), o = (n, r) => {
	if (t) n.adoptedStyleSheets = r.map((e) => e instanceof CSSStyleSheet ? e : e.styleSheet);
	else for (let t of r) {
		let r = document.createElement("style"), i = e.litNonce;
		i !== void 0 && r.setAttribute("nonce", i), r.textContent = t.cssText, n.appendChild(r);
	}
}, s = t ? (e) => e : (e) => e instanceof CSSStyleSheet ? ((e) => {
	let t = "";
	for (let n of e.cssRules) t += n.cssText;
	return a(t);
})(e) : e, { is: c, defineProperty: l, getOwnPropertyDescriptor: u, getOwnPropertyNames: d, getOwnPropertySymbols: f, getPrototypeOf: p } = Object, m = globalThis, h = m.trustedTypes, g = h ? h.emptyScript : "", _ = m.reactiveElementPolyfillSupport, v = (e, t) => e, y = {
	toAttribute(e, t) {
		switch (t) {
			case Boolean:
				e = e ? g : null;
				break;
			case Object:
			case Array: e = e == null ? e : JSON.stringify(e);
		}
		return e;
	},
	fromAttribute(e, t) {
		let n = e;
		switch (t) {
			case Boolean:
				n = e !== null;
				break;
			case Number:
				n = e === null ? null : Number(e);
				break;
			case Object:
			case Array: try {
				n = JSON.parse(e);
			} catch {
				n = null;
			}
		}
		return n;
	}
}, b = (e, t) => !c(e, t), x = {
	attribute: !0,
	type: String,
	converter: y,
	reflect: !1,
	useDefault: !1,
	hasChanged: b
};
Symbol.metadata ??= Symbol("metadata"), m.litPropertyMetadata ??= /* @__PURE__ */ new WeakMap();
var S = class extends HTMLElement {
	static addInitializer(e) {
		this._$Ei(), (this.l ??= []).push(e);
	}
	static get observedAttributes() {
		return this.finalize(), this._$Eh && [...this._$Eh.keys()];
	}
	static createProperty(e, t = x) {
		if (t.state && (t.attribute = !1), this._$Ei(), this.prototype.hasOwnProperty(e) && ((t = Object.create(t)).wrapped = !0), this.elementProperties.set(e, t), !t.noAccessor) {
			let n = Symbol(), r = this.getPropertyDescriptor(e, n, t);
			r !== void 0 && l(this.prototype, e, r);
		}
	}
	static getPropertyDescriptor(e, t, n) {
		let { get: r, set: i } = u(this.prototype, e) ?? {
			get() {
				return this[t];
			},
			set(e) {
				this[t] = e;
			}
		};
		return {
			get: r,
			set(t) {
				let a = r?.call(this);
				i?.call(this, t), this.requestUpdate(e, a, n);
			},
			configurable: !0,
			enumerable: !0
		};
	}
	static getPropertyOptions(e) {
		return this.elementProperties.get(e) ?? x;
	}
	static _$Ei() {
		if (this.hasOwnProperty(v("elementProperties"))) return;
		let e = p(this);
		e.finalize(), e.l !== void 0 && (this.l = [...e.l]), this.elementProperties = new Map(e.elementProperties);
	}
	static finalize() {
		if (this.hasOwnProperty(v("finalized"))) return;
		if (this.finalized = !0, this._$Ei(), this.hasOwnProperty(v("properties"))) {
			let e = this.properties, t = [...d(e), ...f(e)];
			for (let n of t) this.createProperty(n, e[n]);
		}
		let e = this[Symbol.metadata];
		if (e !== null) {
			let t = litPropertyMetadata.get(e);
			if (t !== void 0) for (let [e, n] of t) this.elementProperties.set(e, n);
		}
		this._$Eh = /* @__PURE__ */ new Map();
		for (let [e, t] of this.elementProperties) {
			let n = this._$Eu(e, t);
			n !== void 0 && this._$Eh.set(n, e);
		}
		this.elementStyles = this.finalizeStyles(this.styles);
	}
	static finalizeStyles(e) {
		let t = [];
		if (Array.isArray(e)) {
			let n = new Set(e.flat(1 / 0).reverse());
			for (let e of n) t.unshift(s(e));
		} else e !== void 0 && t.push(s(e));
		return t;
	}
	static _$Eu(e, t) {
		let n = t.attribute;
		return !1 === n ? void 0 : typeof n == "string" ? n : typeof e == "string" ? e.toLowerCase() : void 0;
	}
	constructor() {
		super(), this._$Ep = void 0, this.isUpdatePending = !1, this.hasUpdated = !1, this._$Em = null, this._$Ev();
	}
	_$Ev() {
		this._$ES = new Promise((e) => this.enableUpdating = e), this._$AL = /* @__PURE__ */ new Map(), this._$E_(), this.requestUpdate(), this.constructor.l?.forEach((e) => e(this));
	}
	addController(e) {
		(this._$EO ??= /* @__PURE__ */ new Set()).add(e), this.renderRoot !== void 0 && this.isConnected && e.hostConnected?.();
	}
	removeController(e) {
		this._$EO?.delete(e);
	}
	_$E_() {
		let e = /* @__PURE__ */ new Map(), t = this.constructor.elementProperties;
		for (let n of t.keys()) this.hasOwnProperty(n) && (e.set(n, this[n]), delete this[n]);
		e.size > 0 && (this._$Ep = e);
	}
	createRenderRoot() {
		let e = this.shadowRoot ?? this.attachShadow(this.constructor.shadowRootOptions);
		return o(e, this.constructor.elementStyles), e;
	}
	connectedCallback() {
		this.renderRoot ??= this.createRenderRoot(), this.enableUpdating(!0), this._$EO?.forEach((e) => e.hostConnected?.());
	}
	enableUpdating(e) {}
	disconnectedCallback() {
		this._$EO?.forEach((e) => e.hostDisconnected?.());
	}
	attributeChangedCallback(e, t, n) {
		this._$AK(e, n);
	}
	_$ET(e, t) {
		let n = this.constructor.elementProperties.get(e), r = this.constructor._$Eu(e, n);
		if (r !== void 0 && !0 === n.reflect) {
			let i = (n.converter?.toAttribute === void 0 ? y : n.converter).toAttribute(t, n.type);
			this._$Em = e, i == null ? this.removeAttribute(r) : this.setAttribute(r, i), this._$Em = null;
		}
	}
	_$AK(e, t) {
		let n = this.constructor, r = n._$Eh.get(e);
		if (r !== void 0 && this._$Em !== r) {
			let e = n.getPropertyOptions(r), i = typeof e.converter == "function" ? { fromAttribute: e.converter } : e.converter?.fromAttribute === void 0 ? y : e.converter;
			this._$Em = r;
			let a = i.fromAttribute(t, e.type);
			this[r] = a ?? this._$Ej?.get(r) ?? a, this._$Em = null;
		}
	}
	requestUpdate(e, t, n, r = !1, i) {
		if (e !== void 0) {
			let a = this.constructor;
			if (!1 === r && (i = this[e]), n ??= a.getPropertyOptions(e), !((n.hasChanged ?? b)(i, t) || n.useDefault && n.reflect && i === this._$Ej?.get(e) && !this.hasAttribute(a._$Eu(e, n)))) return;
			this.C(e, t, n);
		}
		!1 === this.isUpdatePending && (this._$ES = this._$EP());
	}
	C(e, t, { useDefault: n, reflect: r, wrapped: i }, a) {
		n && !(this._$Ej ??= /* @__PURE__ */ new Map()).has(e) && (this._$Ej.set(e, a ?? t ?? this[e]), !0 !== i || a !== void 0) || (this._$AL.has(e) || (this.hasUpdated || n || (t = void 0), this._$AL.set(e, t)), !0 === r && this._$Em !== e && (this._$Eq ??= /* @__PURE__ */ new Set()).add(e));
	}
	async _$EP() {
		this.isUpdatePending = !0;
		try {
			await this._$ES;
		} catch (e) {
			Promise.reject(e);
		}
		let e = this.scheduleUpdate();
		return e != null && await e, !this.isUpdatePending;
	}
	scheduleUpdate() {
		return this.performUpdate();
	}
	performUpdate() {
		if (!this.isUpdatePending) return;
		if (!this.hasUpdated) {
			if (this.renderRoot ??= this.createRenderRoot(), this._$Ep) {
				for (let [e, t] of this._$Ep) this[e] = t;
				this._$Ep = void 0;
			}
			let e = this.constructor.elementProperties;
			if (e.size > 0) for (let [t, n] of e) {
				let { wrapped: e } = n, r = this[t];
				!0 !== e || this._$AL.has(t) || r === void 0 || this.C(t, void 0, n, r);
			}
		}
		let e = !1, t = this._$AL;
		try {
			e = this.shouldUpdate(t), e ? (this.willUpdate(t), this._$EO?.forEach((e) => e.hostUpdate?.()), this.update(t)) : this._$EM();
		} catch (t) {
			throw e = !1, this._$EM(), t;
		}
		e && this._$AE(t);
	}
	willUpdate(e) {}
	_$AE(e) {
		this._$EO?.forEach((e) => e.hostUpdated?.()), this.hasUpdated || (this.hasUpdated = !0, this.firstUpdated(e)), this.updated(e);
	}
	_$EM() {
		this._$AL = /* @__PURE__ */ new Map(), this.isUpdatePending = !1;
	}
	get updateComplete() {
		return this.getUpdateComplete();
	}
	getUpdateComplete() {
		return this._$ES;
	}
	shouldUpdate(e) {
		return !0;
	}
	update(e) {
		this._$Eq &&= this._$Eq.forEach((e) => this._$ET(e, this[e])), this._$EM();
	}
	updated(e) {}
	firstUpdated(e) {}
};
S.elementStyles = [], S.shadowRootOptions = { mode: "open" }, S[v("elementProperties")] = /* @__PURE__ */ new Map(), S[v("finalized")] = /* @__PURE__ */ new Map(), _?.({ ReactiveElement: S }), (m.reactiveElementVersions ??= []).push("2.1.2");
var C = globalThis, w = (e) => e, T = C.trustedTypes, ee = T ? T.createPolicy("lit-html", { createHTML: (e) => e }) : void 0, te = "$lit$", E = `lit$${Math.random().toFixed(9).slice(2)}$`, ne = "?" + E, re = `<${ne}>`, D = document, O = () => D.createComment(""), k = (e) => e === null || typeof e != "object" && typeof e != "function", ie = Array.isArray, ae = (e) => ie(e) || typeof e?.[Symbol.iterator] == "function", oe = "[ 	\n\f\r]", A = /<(?:(!--|\/[^a-zA-Z])|(\/?[a-zA-Z][^>\s]*)|(\/?$))/g, se = /-->/g, ce = />/g, j = RegExp(`>|${oe}(?:([^\\s"'>=/]+)(${oe}*=${oe}*(?:[^ \t\n\f\r"'\`<>=]|("|')|))|$)`, "g"), le = /'/g, ue = /"/g, de = /^(?:script|style|textarea|title)$/i, fe = (e) => (t, ...n) => ({
	_$litType$: e,
	strings: t,
	values: n
}), M = fe(1), pe = fe(2), N = Symbol.for("lit-noChange"), P = Symbol.for("lit-nothing"), me = /* @__PURE__ */ new WeakMap(), F = D.createTreeWalker(D, 129);
function he(e, t) {
	if (!ie(e) || !e.hasOwnProperty("raw")) throw Error("invalid template strings array");
	return ee === void 0 ? t : ee.createHTML(t);
}
var ge = (e, t) => {
	let n = e.length - 1, r = [], i, a = t === 2 ? "<svg>" : t === 3 ? "<math>" : "", o = A;
	for (let t = 0; t < n; t++) {
		let n = e[t], s, c, l = -1, u = 0;
		for (; u < n.length && (o.lastIndex = u, c = o.exec(n), c !== null);) u = o.lastIndex, o === A ? c[1] === "!--" ? o = se : c[1] === void 0 ? c[2] === void 0 ? c[3] !== void 0 && (o = j) : (de.test(c[2]) && (i = RegExp("</" + c[2], "g")), o = j) : o = ce : o === j ? c[0] === ">" ? (o = i ?? A, l = -1) : c[1] === void 0 ? l = -2 : (l = o.lastIndex - c[2].length, s = c[1], o = c[3] === void 0 ? j : c[3] === "\"" ? ue : le) : o === ue || o === le ? o = j : o === se || o === ce ? o = A : (o = j, i = void 0);
		let d = o === j && e[t + 1].startsWith("/>") ? " " : "";
		a += o === A ? n + re : l >= 0 ? (r.push(s), n.slice(0, l) + te + n.slice(l) + E + d) : n + E + (l === -2 ? t : d);
	}
	return [he(e, a + (e[n] || "<?>") + (t === 2 ? "</svg>" : t === 3 ? "</math>" : "")), r];
}, _e = class e {
	constructor({ strings: t, _$litType$: n }, r) {
		let i;
		this.parts = [];
		let a = 0, o = 0, s = t.length - 1, c = this.parts, [l, u] = ge(t, n);
		if (this.el = e.createElement(l, r), F.currentNode = this.el.content, n === 2 || n === 3) {
			let e = this.el.content.firstChild;
			e.replaceWith(...e.childNodes);
		}
		for (; (i = F.nextNode()) !== null && c.length < s;) {
			if (i.nodeType === 1) {
				if (i.hasAttributes()) for (let e of i.getAttributeNames()) if (e.endsWith(te)) {
					let t = u[o++], n = i.getAttribute(e).split(E), r = /([.?@])?(.*)/.exec(t);
					c.push({
						type: 1,
						index: a,
						name: r[2],
						strings: n,
						ctor: r[1] === "." ? be : r[1] === "?" ? xe : r[1] === "@" ? Se : L
					}), i.removeAttribute(e);
				} else e.startsWith(E) && (c.push({
					type: 6,
					index: a
				}), i.removeAttribute(e));
				if (de.test(i.tagName)) {
					let e = i.textContent.split(E), t = e.length - 1;
					if (t > 0) {
						i.textContent = T ? T.emptyScript : "";
						for (let n = 0; n < t; n++) i.append(e[n], O()), F.nextNode(), c.push({
							type: 2,
							index: ++a
						});
						i.append(e[t], O());
					}
				}
			} else if (i.nodeType === 8) {
				if (i.data === ne) c.push({
					type: 2,
					index: a
				});
				else {
					let e = -1;
					for (; (e = i.data.indexOf(E, e + 1)) !== -1;) c.push({
						type: 7,
						index: a
					}), e += E.length - 1;
				}
			}
			a++;
		}
	}
	static createElement(e, t) {
		let n = D.createElement("template");
		return n.innerHTML = e, n;
	}
};
function I(e, t, n = e, r) {
	if (t === N) return t;
	let i = r === void 0 ? n._$Cl : n._$Co?.[r], a = k(t) ? void 0 : t._$litDirective$;
	return i?.constructor !== a && (i?._$AO?.(!1), a === void 0 ? i = void 0 : (i = new a(e), i._$AT(e, n, r)), r === void 0 ? n._$Cl = i : (n._$Co ??= [])[r] = i), i !== void 0 && (t = I(e, i._$AS(e, t.values), i, r)), t;
}
var ve = class {
	constructor(e, t) {
		this._$AV = [], this._$AN = void 0, this._$AD = e, this._$AM = t;
	}
	get parentNode() {
		return this._$AM.parentNode;
	}
	get _$AU() {
		return this._$AM._$AU;
	}
	u(e) {
		let { el: { content: t }, parts: n } = this._$AD, r = (e?.creationScope ?? D).importNode(t, !0);
		F.currentNode = r;
		let i = F.nextNode(), a = 0, o = 0, s = n[0];
		for (; s !== void 0;) {
			if (a === s.index) {
				let t;
				s.type === 2 ? t = new ye(i, i.nextSibling, this, e) : s.type === 1 ? t = new s.ctor(i, s.name, s.strings, this, e) : s.type === 6 && (t = new Ce(i, this, e)), this._$AV.push(t), s = n[++o];
			}
			a !== s?.index && (i = F.nextNode(), a++);
		}
		return F.currentNode = D, r;
	}
	p(e) {
		let t = 0;
		for (let n of this._$AV) n !== void 0 && (n.strings === void 0 ? n._$AI(e[t]) : (n._$AI(e, n, t), t += n.strings.length - 2)), t++;
	}
}, ye = class e {
	get _$AU() {
		return this._$AM?._$AU ?? this._$Cv;
	}
	constructor(e, t, n, r) {
		this.type = 2, this._$AH = P, this._$AN = void 0, this._$AA = e, this._$AB = t, this._$AM = n, this.options = r, this._$Cv = r?.isConnected ?? !0;
	}
	get parentNode() {
		let e = this._$AA.parentNode, t = this._$AM;
		return t !== void 0 && e?.nodeType === 11 && (e = t.parentNode), e;
	}
	get startNode() {
		return this._$AA;
	}
	get endNode() {
		return this._$AB;
	}
	_$AI(e, t = this) {
		e = I(this, e, t), k(e) ? e === P || e == null || e === "" ? (this._$AH !== P && this._$AR(), this._$AH = P) : e !== this._$AH && e !== N && this._(e) : e._$litType$ === void 0 ? e.nodeType === void 0 ? ae(e) ? this.k(e) : this._(e) : this.T(e) : this.$(e);
	}
	O(e) {
		return this._$AA.parentNode.insertBefore(e, this._$AB);
	}
	T(e) {
		this._$AH !== e && (this._$AR(), this._$AH = this.O(e));
	}
	_(e) {
		this._$AH !== P && k(this._$AH) ? this._$AA.nextSibling.data = e : this.T(D.createTextNode(e)), this._$AH = e;
	}
	$(e) {
		let { values: t, _$litType$: n } = e, r = typeof n == "number" ? this._$AC(e) : (n.el === void 0 && (n.el = _e.createElement(he(n.h, n.h[0]), this.options)), n);
		if (this._$AH?._$AD === r) this._$AH.p(t);
		else {
			let e = new ve(r, this), n = e.u(this.options);
			e.p(t), this.T(n), this._$AH = e;
		}
	}
	_$AC(e) {
		let t = me.get(e.strings);
		return t === void 0 && me.set(e.strings, t = new _e(e)), t;
	}
	k(t) {
		ie(this._$AH) || (this._$AH = [], this._$AR());
		let n = this._$AH, r, i = 0;
		for (let a of t) i === n.length ? n.push(r = new e(this.O(O()), this.O(O()), this, this.options)) : r = n[i], r._$AI(a), i++;
		i < n.length && (this._$AR(r && r._$AB.nextSibling, i), n.length = i);
	}
	_$AR(e = this._$AA.nextSibling, t) {
		for (this._$AP?.(!1, !0, t); e !== this._$AB;) {
			let t = w(e).nextSibling;
			w(e).remove(), e = t;
		}
	}
	setConnected(e) {
		this._$AM === void 0 && (this._$Cv = e, this._$AP?.(e));
	}
}, L = class {
	get tagName() {
		return this.element.tagName;
	}
	get _$AU() {
		return this._$AM._$AU;
	}
	constructor(e, t, n, r, i) {
		this.type = 1, this._$AH = P, this._$AN = void 0, this.element = e, this.name = t, this._$AM = r, this.options = i, n.length > 2 || n[0] !== "" || n[1] !== "" ? (this._$AH = Array(n.length - 1).fill(/* @__PURE__ */ new String()), this.strings = n) : this._$AH = P;
	}
	_$AI(e, t = this, n, r) {
		let i = this.strings, a = !1;
		if (i === void 0) e = I(this, e, t, 0), a = !k(e) || e !== this._$AH && e !== N, a && (this._$AH = e);
		else {
			let r = e, o, s;
			for (e = i[0], o = 0; o < i.length - 1; o++) s = I(this, r[n + o], t, o), s === N && (s = this._$AH[o]), a ||= !k(s) || s !== this._$AH[o], s === P ? e = P : e !== P && (e += (s ?? "") + i[o + 1]), this._$AH[o] = s;
		}
		a && !r && this.j(e);
	}
	j(e) {
		e === P ? this.element.removeAttribute(this.name) : this.element.setAttribute(this.name, e ?? "");
	}
}, be = class extends L {
	constructor() {
		super(...arguments), this.type = 3;
	}
	j(e) {
		this.element[this.name] = e === P ? void 0 : e;
	}
}, xe = class extends L {
	constructor() {
		super(...arguments), this.type = 4;
	}
	j(e) {
		this.element.toggleAttribute(this.name, !!e && e !== P);
	}
}, Se = class extends L {
	constructor(e, t, n, r, i) {
		super(e, t, n, r, i), this.type = 5;
	}
	_$AI(e, t = this) {
		if ((e = I(this, e, t, 0) ?? P) === N) return;
		let n = this._$AH, r = e === P && n !== P || e.capture !== n.capture || e.once !== n.once || e.passive !== n.passive, i = e !== P && (n === P || r);
		r && this.element.removeEventListener(this.name, this, n), i && this.element.addEventListener(this.name, this, e), this._$AH = e;
	}
	handleEvent(e) {
		typeof this._$AH == "function" ? this._$AH.call(this.options?.host ?? this.element, e) : this._$AH.handleEvent(e);
	}
}, Ce = class {
	constructor(e, t, n) {
		this.element = e, this.type = 6, this._$AN = void 0, this._$AM = t, this.options = n;
	}
	get _$AU() {
		return this._$AM._$AU;
	}
	_$AI(e) {
		I(this, e);
	}
}, we = C.litHtmlPolyfillSupport;
we?.(_e, ye), (C.litHtmlVersions ??= []).push("3.3.3");
var Te = (e, t, n) => {
	let r = n?.renderBefore ?? t, i = r._$litPart$;
	if (i === void 0) {
		let e = n?.renderBefore ?? null;
		r._$litPart$ = i = new ye(t.insertBefore(O(), e), e, void 0, n ?? {});
	}
	return i._$AI(e), i;
}, Ee = globalThis, R = class extends S {
	constructor() {
		super(...arguments), this.renderOptions = { host: this }, this._$Do = void 0;
	}
	createRenderRoot() {
		let e = super.createRenderRoot();
		return this.renderOptions.renderBefore ??= e.firstChild, e;
	}
	update(e) {
		let t = this.render();
		this.hasUpdated || (this.renderOptions.isConnected = this.isConnected), super.update(e), this._$Do = Te(t, this.renderRoot, this.renderOptions);
	}
	connectedCallback() {
		super.connectedCallback(), this._$Do?.setConnected(!0);
	}
	disconnectedCallback() {
		super.disconnectedCallback(), this._$Do?.setConnected(!1);
	}
	render() {
		return N;
	}
};
R._$litElement$ = !0, R.finalized = !0, Ee.litElementHydrateSupport?.({ LitElement: R });
var De = Ee.litElementPolyfillSupport;
De?.({ LitElement: R }), (Ee.litElementVersions ??= []).push("4.2.2");
var Oe = Math.PI / 180;
function ke(e, t, n, r, i) {
	let { rows: a, columns: o, nodes: s } = e, c = Math.min(Math.max(n, e.range_deg[0]), e.range_deg[1]), l = Math.min(Math.max(t, e.range_nm[0]), e.range_nm[1]);
	if (e.inverse_square > 0) {
		let t = Math.sin(c * Oe);
		l *= Math.sqrt(1 - t * t * e.inverse_square);
	}
	let u = Math.max((l - e.first_nm) / e.step_nm, 0), d = Math.min(Math.floor(u), o - 2), f = u - d, p = 1 - f, m = (f * 2 + 1) * p * p, h = f * p * p, g = f * f * (3 - 2 * f), _ = -(f * f * p), v = 0, y = Ae;
	if (a > 1) {
		let t = (c - e.first_deg) / e.step_deg;
		v = Math.min(Math.max(Math.floor(t) - 1, 0), a - 4);
		let n = t - v, r = n - 1, i = n - 2, o = n - 3;
		y = [
			r * i * o / -6,
			n * i * o / 2,
			n * r * o / -2,
			n * r * i / 6
		];
	}
	let b = 0, x = 0, S = 0;
	for (let e = 0; e < y.length; e++) {
		let t = ((v + e) * o + d) * 6, n = y[e];
		b += n * (m * s[t] + h * s[t + 3] + g * s[t + 6] + _ * s[t + 9]), x += n * (m * s[t + 1] + h * s[t + 4] + g * s[t + 7] + _ * s[t + 10]), S += n * (m * s[t + 2] + h * s[t + 5] + g * s[t + 8] + _ * s[t + 11]);
	}
	r[i] = b, r[i + 1] = x, r[i + 2] = S;
}
var Ae = [1], je = [380, 780];
function z(e, t, n) {
	let r = Math.min(Math.max((n - e) / (t - e), 0), 1);
	return r * r * (3 - 2 * r);
}
var B = class {
	constructor(e, t, n, r, i) {
		this.half_width = n, this.half_height = r, this.soft = i;
		let a = e * Math.PI / 180, o = t * Math.PI / 180;
		this.normal = [
			Math.cos(o) * Math.sin(a),
			Math.sin(o),
			Math.cos(o) * Math.cos(a)
		], this.right = [
			Math.cos(a),
			0,
			-Math.sin(a)
		], this.up = [
			-Math.sin(o) * Math.sin(a),
			Math.cos(o),
			-Math.sin(o) * Math.cos(a)
		];
	}
	meet(e, t, n, r) {
		let [i, a, o] = [
			this.normal,
			this.right,
			this.up
		], s = e * i[0] + t * i[1] + n * i[2];
		if (s < .05) return 0;
		let c = (e * a[0] + t * a[1] + n * a[2]) / s, l = (e * o[0] + t * o[1] + n * o[2]) / s;
		return r[0] = c / this.half_width, r[1] = l / this.half_height, z(-this.soft, this.soft, this.half_width - Math.abs(c)) * z(-this.soft, this.soft, this.half_height - Math.abs(l));
	}
};
function Me(e, t, n) {
	let r = (e + 1) / 2 * t, i = Math.round(r);
	return i < .5 || i > t - .5 ? 1 : z(.023, .033, Math.abs(r - i) * 2 * n / t);
}
var Ne = new B(-44, 26, .66, .8, .01), Pe = new B(60, 12, .6, 1, .12), Fe = [
	[new B(-120, 6, .24, 1.2, .12), 2.6],
	[new B(118, 6, .28, 1.2, .12), 3.4],
	[new B(10, 78, .75, .26, .08), 5],
	[new B(0, -60, 1.1, .4, .25), .9]
], V = [0, 0], Ie = (e, t, n) => {
	let r = .008 + .03 * z(.5, 1, -n - .25 * t) + .75 * z(.3, 1, .5 + .5 * n) * (.65 + .35 * t), i = Ne.meet(e, t, n, V);
	if (i > 0) {
		let e = Me(V[0], 2, Ne.half_width) * Me(V[1], 3, Ne.half_height);
		r += i * e * (7 + 2.5 * V[1]);
	}
	i = Pe.meet(e, t, n, V), i > 0 && (r += i * (3.4 - .8 * V[0]));
	for (let [i, a] of Fe) r += i.meet(e, t, n, V) * a;
	return r;
}, Le = (e, t) => (1 + 2 * Math.max(t, 0)) / 3, Re = () => 1;
function H(e) {
	return e === "studio" ? Ie : e === "overcast" ? Le : Re;
}
var ze = [
	"free-bubble-preview",
	"bubble-on-bath-preview",
	"late-preview",
	"vertical-film-preview",
	"still"
], Be = [
	"D65",
	"A",
	"D50",
	"E",
	"FL2",
	"FL11",
	"LED-B1",
	"blackbody:4000",
	"lines:589.158*2,589.756",
	"lines:546.227,404.77,435.96,577.12,579.23",
	"laser:632.99"
], Ve = {
	bubble: "air / soap ? / air",
	rings: "air / MgF2 99.75 / N-BK7 1e6 incoherent / air ? / N-BK7",
	slick: "air / 1.47 ? / water",
	titanium: "air / TiO2 ? / Ti",
	wafer: "air / SiO2 ? / Si",
	film: "air / soap ? / air",
	learn: "air / soap ? / air"
}, He = 2.4, Ue = [
	{
		name: "stack",
		kind: "stack",
		default: Ve.film,
		of: Ve
	},
	{
		name: "thickness_nm",
		kind: "number",
		unit: "nm",
		range: [0, 5e3],
		step: 1,
		default: 320,
		of: {
			bubble: 450,
			rings: 0,
			slick: 900,
			titanium: 125,
			wafer: 300,
			film: 320,
			learn: 320
		},
		scenes: [
			"bubble",
			"rings",
			"slick",
			"titanium",
			"wafer",
			"film"
		]
	},
	{
		name: "angle_deg",
		kind: "number",
		unit: "°",
		range: [0, 80],
		step: 1,
		default: 0,
		of: {
			wafer: 35,
			film: 30,
			titanium: 20
		},
		scenes: [
			"titanium",
			"wafer",
			"film"
		]
	},
	{
		name: "illuminant",
		kind: "illuminant",
		default: "D65"
	},
	{
		name: "preset",
		kind: "choice",
		choices: ze,
		default: ze[0],
		scenes: ["bubble"]
	},
	{
		name: "playing",
		kind: "flag",
		default: !0,
		scenes: ["bubble"]
	},
	{
		name: "age_s",
		kind: "number",
		unit: "s",
		range: [0, 20],
		step: .1,
		default: .8,
		scenes: ["bubble"]
	},
	{
		name: "wind_m_s",
		kind: "number",
		unit: "m/s",
		range: [0, .5],
		step: .01,
		default: .15,
		scenes: ["bubble"]
	},
	{
		name: "gravity_m_s2",
		kind: "number",
		unit: "m/s²",
		range: [0, 25],
		step: .1,
		default: 9.81,
		scenes: ["bubble"]
	},
	{
		name: "walls",
		kind: "choice",
		choices: ["2", "1"],
		default: "2",
		scenes: ["bubble"]
	},
	{
		name: "seed",
		kind: "whole",
		range: [0, 999999],
		step: 1,
		default: 1,
		scenes: ["bubble", "slick"]
	},
	{
		name: "radius_mm",
		kind: "number",
		unit: "mm",
		range: [300, 1e4],
		step: 10,
		default: 1e3,
		scenes: ["rings"]
	},
	{
		name: "view_mm",
		kind: "number",
		unit: "mm",
		range: [1, 16],
		step: .1,
		default: 4.8,
		scenes: ["rings"]
	},
	{
		name: "volts",
		kind: "number",
		unit: "V",
		range: [0, 110],
		step: 1,
		default: 50,
		scenes: ["titanium"]
	},
	{
		name: "edge_nm",
		kind: "number",
		unit: "nm",
		range: [0, 2e3],
		step: 1,
		default: 340,
		scenes: ["wafer"]
	},
	{
		name: "thickest_nm",
		kind: "number",
		unit: "nm",
		range: [100, 5e3],
		step: 10,
		default: 1200,
		scenes: ["film"]
	},
	{
		name: "model",
		kind: "choice",
		choices: ["exact", "two-beam"],
		default: "exact",
		scenes: ["film"]
	},
	{
		name: "environment",
		kind: "choice",
		choices: [
			"studio",
			"overcast",
			"uniform"
		],
		default: "studio",
		of: {
			slick: "overcast",
			titanium: "overcast",
			wafer: "overcast"
		},
		scenes: [
			"bubble",
			"slick",
			"titanium",
			"wafer"
		]
	},
	{
		name: "exposure",
		kind: "number",
		unit: "stops",
		range: [-5, 5],
		step: .1,
		default: 0,
		scenes: [
			"bubble",
			"rings",
			"slick",
			"titanium",
			"wafer"
		]
	},
	{
		name: "story",
		kind: "whole",
		range: [0, 6],
		default: 0,
		of: {},
		hidden: !0
	},
	{
		name: "sheet",
		kind: "whole",
		range: [0, 999999],
		default: 0,
		of: {},
		scenes: ["learn"],
		hidden: !0
	},
	{
		name: "theme",
		kind: "choice",
		choices: [
			"auto",
			"light",
			"dark"
		],
		default: "auto",
		hidden: !0
	}
];
new Map(Ue.map((e) => [e.name, e]));
function We(e, t) {
	return e.of?.[t] ?? e.default;
}
function Ge(e) {
	let t = { scene: e };
	for (let n of Ue) t[n.name] = We(n, e);
	return t;
}
var U = 180 / Math.PI;
function W(e, t, n, r, i = !1) {
	let a = e * t, o = {
		width: e,
		height: t,
		field: n,
		repeats: i,
		passes: r,
		front: new Float32Array(a * 4),
		back: new Float32Array(a * 4),
		behind: new Float32Array(a * 2)
	};
	for (let e = 2; e < o.front.length; e += 4) o.front[e] = o.back[e] = -1;
	return o;
}
function G(e, t, n, r, i, a) {
	let o = t * 4;
	e[o] = n, e[o + 1] = r, e[o + 2] = Math.acos(Math.min(Math.max(i, 0), 1)) * U, e[o + 3] = a;
}
function K(e, t, n, r, i, a) {
	let o = Ke([
		r[0] - n[0],
		r[1] - n[1],
		r[2] - n[2]
	]), s = Ke([
		-o[2],
		0,
		o[0]
	]), c = [
		s[1] * o[2] - s[2] * o[1],
		s[2] * o[0] - s[0] * o[2],
		s[0] * o[1] - s[1] * o[0]
	], l = Math.tan(i / 2 / U) / (Math.min(e, t) / 2);
	for (let n = 0; n < t; n++) {
		let r = (t / 2 - n - .5) * l;
		for (let t = 0; t < e; t++) {
			let i = (t + .5 - e / 2) * l, u = o[0] + i * s[0] + r * c[0], d = o[1] + i * s[1] + r * c[1], f = o[2] + i * s[2] + r * c[2], p = 1 / Math.sqrt(u * u + d * d + f * f);
			a(n * e + t, u * p, d * p, f * p);
		}
	}
}
function Ke(e) {
	let t = 1 / Math.hypot(e[0], e[1], e[2]);
	return e.map((e) => e * t);
}
function qe(e, t, n, r) {
	let i = Math.atan2(-n, e) / (2 * Math.PI);
	return [i < 0 ? i + 1 : i, Math.acos(Math.min(Math.max(t, -1), 1)) / r];
}
var q = 16, J = 4, Y = 2.5;
function Je({ width: e, height: t, state: n }) {
	let r = H(String(n.environment)), i = n.preset === "still", a = n.walls === "2", o = W(e, t, !0, a), s = n.environment === "uniform", c = Math.tan(35 / 2 / U) / (Math.min(e, t) / 2) * q;
	return K(e, t, [
		0,
		0,
		q
	], [
		0,
		0,
		0
	], 35, (e, t, n, l) => {
		o.behind[2 * e] = a ? r(t, n, l) : s ? 0 : r(t, n, l);
		let u = q * l, d = Math.sqrt(Math.max(256 - u * u, 0)), f = Math.min(Math.max((J - d) / c + .5, 0), 1);
		if (f <= 0) return;
		o.behind[2 * e + 1] = f;
		let p = Math.sqrt(Math.max(16 - d * d, 0));
		for (let [s, c] of [[o.front, -u - p], [o.back, -u + p]]) {
			let o = t * c / J, u = n * c / J, d = (q + l * c) / J, f = t * o + n * u + l * d, p = r(t - 2 * f * o, n - 2 * f * u, l - 2 * f * d), [m, h] = i ? [.5, (1 - u) / 2] : qe(o, u, d, Math.PI);
			if (G(s, e, m, h, Math.abs(f), p), !a) break;
		}
	}), o;
}
function Ye({ width: e, height: t, state: n, water: r }) {
	let i = H(String(n.environment)), a = n.walls === "2", o = W(e, t, !0, a), s = [
		0,
		4.2,
		11
	], c = Math.tan(31 / 2 / U) / (Math.min(e, t) / 2) * Math.hypot(...s), l = (e, t, n, r) => {
		let i = e[0] * t + e[1] * n + e[2] * r, a = Math.sqrt(Math.max(e[0] * e[0] + e[1] * e[1] + e[2] * e[2] - i * i, 0)), o = Math.sqrt(Math.max(Y * Y - a * a, 0));
		return [
			-i - o,
			-i + o,
			a
		];
	}, u = (e, t, n, r, i, a, o, s) => {
		let c = (n[0] + r * o) / Y, l = (n[1] + i * o) / Y, u = (n[2] + a * o) / Y, f = r * c + i * l + a * u, [p, m] = qe(c, l, u, Math.PI / 2);
		G(e, t, p, m, Math.abs(f), s * d(r - 2 * f * c, i - 2 * f * l, a - 2 * f * u));
	}, d = (e, t, n) => t >= 0 ? i(e, t, n) : p(-t) * i(e, -t, n), f = r(), p = (e) => f[Math.round(Math.acos(Math.min(e, 1)) * U)];
	return K(e, t, s, [
		0,
		.95,
		0
	], 31, (e, t, r, i) => {
		let [f, m, h] = l(s, t, r, i), g = Math.min(Math.max((Y - h) / c + .5, 0), 1);
		o.behind[2 * e] = a || n.environment !== "uniform" ? d(t, r, i) : 0;
		let _ = s[1] + r * f >= 0;
		if (g > 0 && f > 0 && _) {
			o.behind[2 * e + 1] = g, u(o.front, e, s, t, r, i, f, 1), a && s[1] + r * m >= 0 && u(o.back, e, s, t, r, i, m, 1);
			return;
		}
		if (r >= 0 || !a) return;
		let v = -s[1] / r, y = [
			s[0] + t * v,
			0,
			s[2] + i * v
		], [b, , x] = l(y, t, -r, i), S = Math.min(Math.max((Y - x) / c + .5, 0), 1);
		S <= 0 || b <= 0 || -r * b < 0 || (o.behind[2 * e + 1] = S, u(o.front, e, y, t, -r, i, b, p(-r)));
	}), o;
}
function Xe({ width: e, height: t }) {
	let n = W(e, t, !0, !1), r = [5, 3], i = .14;
	return K(e, t, [
		0,
		0,
		20
	], [
		0,
		0,
		0
	], 2 * Math.atan(3.4 / 20) * U * Math.max(1, 5.3 / 3.4 * Math.min(t / e, 1)), (e, t, a, o) => {
		let s = -20 / o, [c, l] = [t * s, a * s], [u, d] = [Math.abs(c), Math.abs(l)];
		u > r[0] + i || d > r[1] + i ? n.behind[2 * e] = .004 : u > r[0] || d > r[1] ? n.behind[2 * e] = .03 : (G(n.front, e, (c / r[0] + 1) / 2, (1 - l / r[1]) / 2, -o, 1), n.behind[2 * e + 1] = 1);
	}), n;
}
function Ze({ width: e, height: t, state: n }) {
	let r = W(e, t, !1, !1), i = Number(n.view_mm), [a, o] = [Number(n.radius_mm), Number(n.thickness_nm)], s = i / Math.min(e, t);
	for (let n = 0; n < t; n++) for (let i = 0; i < e; i++) {
		let c = ((i + .5 - e / 2) * s) ** 2 + ((n + .5 - t / 2) * s) ** 2, l = o + 1e6 * c / (a + Math.sqrt(a * a - c)), u = n * e + i;
		G(r.front, u, l, 0, 1, 1), r.behind[2 * u + 1] = 1;
	}
	return r;
}
function Qe({ width: e, height: t, state: n }) {
	let r = H(String(n.environment)), i = W(e, t, !0, !1, !0), a = [
		0,
		.5,
		.62
	];
	return K(e, t, a, [
		0,
		0,
		.06
	], 40, (e, t, n, o) => {
		if (i.behind[2 * e] = r(t, n, o), n > -.02) return;
		let s = -a[1] / n;
		G(i.front, e, t * s * .8 + .5, (o * s + a[2]) * .8 + .5, -n, r(t, -n, o)), i.behind[2 * e + 1] = 1;
	}), i;
}
function $e(e) {
	let t = H(e);
	return e === "studio" ? (e, n, r) => t(e, -r, n) : t;
}
function et({ width: e, height: t, state: n }) {
	let r = $e(String(n.environment)), i = W(e, t, !1, !1), a = Number(n.angle_deg) / U, o = 1 / Math.min(e / 1.25, t), s = Number(n.thickness_nm), c = n.environment === "studio" ? 2.2 : 1, [l, u, d] = [
		0,
		-Math.cos(a),
		-Math.sin(a)
	], f = o;
	for (let n = 0; n < t; n++) for (let a = 0; a < e; a++) {
		let p = n * e + a, m = (a + .5 - e / 2) * o, h = (t / 2 - n - .5) * o;
		i.behind[2 * p] = .03;
		let [g, _] = [m, h - .13], v = Math.min(Math.max((.33 - Math.hypot(g, _)) / f + .5, 0), 1), y = Math.min(Math.max((.575 - Math.abs(m)) / f + .5, 0), Math.max((.085 - Math.abs(h + .36)) / f + .5, 0), 1);
		if (v <= 0 && y <= 0) continue;
		let b = v > 0 ? .75 : 0, [x, S] = [g * b, -_ * b], C = Math.sqrt(1 - x * x - S * S), w = l * x + u * C + d * S, T = r(l - 2 * w * x, u - 2 * w * C, d - 2 * w * S), ee = Math.min(Math.max((m / .575 + 1) / 2, 0), 1) * 110;
		G(i.front, p, v > 0 ? s : 5 + He * ee, 0, -w, v > 0 ? T : c), i.behind[2 * p + 1] = Math.max(v, y);
	}
	return i;
}
function tt({ width: e, height: t, state: n }) {
	let r = $e(String(n.environment)), i = W(e, t, !1, !1), a = Number(n.angle_deg) / U, [o, s] = [Number(n.thickness_nm), Number(n.edge_nm)], c = [
		0,
		40 * Math.cos(a),
		40 * Math.sin(a) + 1e-6
	], l = Math.tan(17 / 2 / U) / (Math.min(e, t) / 2) * 40;
	return K(e, t, c, [
		0,
		0,
		0
	], 17, (e, t, n, a) => {
		i.behind[2 * e] = .02;
		let u = -c[1] / n, [d, f] = [t * u, c[2] + a * u], p = Math.hypot(d, f), m = Math.min(Math.max(Math.min(5 - p, 4.68 - f) / l + .5, 0), 1);
		m <= 0 || (G(i.front, e, o + (s - o) * (p / 5) ** 2, 0, -n, r(t, -n, a)), i.behind[2 * e + 1] = m);
	}), i;
}
function nt({ width: e, height: t, state: n }) {
	let r = W(e, t, !1, !1), i = Number(n.thickest_nm);
	for (let n = 0; n < t; n++) {
		let a = Math.cos((n + .5) / t * 80 / U);
		for (let t = 0; t < e; t++) {
			let o = n * e + t;
			G(r.front, o, (t + .5) / e * i, 0, a, Re(0, 1, 0)), r.behind[2 * o + 1] = 1;
		}
	}
	return r;
}
function rt(e) {
	switch (e.state.scene) {
		case "rings": return Ze(e);
		case "slick": return Qe(e);
		case "titanium": return et(e);
		case "wafer": return tt(e);
		case "film": return nt(e);
		default: switch (e.state.preset) {
			case "bubble-on-bath-preview":
			case "late-preview": return Ye(e);
			case "vertical-film-preview": return Xe(e);
			default: return Je(e);
		}
	}
}
function it(e, t, n, r) {
	let { columns: i, rows: a, thickness_nm: o } = e, s = t * i - .5, c = r ? n * a - .5 : Math.min(Math.max(n * a - .5, 0), a - 1), [l, u] = [Math.floor(s), Math.floor(c)], [d, f] = [s - l, c - u], p = X(l, i), m = X(l + 1, i), h = (r ? X(u, a) : Math.min(u, a - 1)) * i, g = (r ? X(u + 1, a) : Math.min(u + 1, a - 1)) * i, _ = o[h + p] * (1 - d) + o[h + m] * d, v = o[g + p] * (1 - d) + o[g + m] * d;
	return _ * (1 - f) + v * f;
}
function X(e, t) {
	return (e % t + t) % t;
}
var at = 2, ot = 512, st = 2048;
function ct(e) {
	let [t, n] = [e.first_nm, e.first_nm + (e.columns - 1) * e.step_nm], r = Math.ceil((n - t) / at) + 1;
	if (r > st) return null;
	let [i, a] = e.range_deg, o = e.rows === 1 || i === a ? 1 : ot, s = o === 1 ? 1 : (a - i) / (o - 1), c = new Uint32Array(o * r * 4), l = /* @__PURE__ */ new Float32Array(3), u = {
		...e,
		inverse_square: 0,
		range_nm: [t, n]
	};
	for (let e = 0; e < o; e++) {
		let n = [
			0,
			0,
			0
		];
		for (let a = r - 1; a >= 0; a--) {
			ke(u, t + a * at, i + e * s, l, 0);
			let [o, d, f] = [
				dt(l[0]),
				dt(l[1]),
				dt(l[2])
			], [p, m, h] = a === r - 1 ? [
				o,
				d,
				f
			] : n, g = 4 * (e * r + a);
			c[g] = o | d << 16, c[g + 1] = f | p << 16, c[g + 2] = m | h << 16, n = [
				o,
				d,
				f
			];
		}
	}
	return {
		rows: o,
		columns: r,
		texels: c,
		axes: [
			t,
			at,
			i,
			s
		]
	};
}
var lt = /* @__PURE__ */ new Float32Array(1), ut = new Uint32Array(lt.buffer);
function dt(e) {
	lt[0] = Math.min(Math.max(e, 0), 65504);
	let t = ut[0] + 4096;
	return t < 947912704 ? 0 : t - 939524096 >> 13;
}
var ft = [
	"FIELD",
	"REPEATS",
	"PASSES",
	"DRAFT",
	"ANSWER"
], pt = "#version 300 es\nvoid main() {\n  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);\n  gl_Position = vec4(corner, 0.0, 1.0);\n}";
function mt(e) {
	return `#version 300 es\n${e.map((e) => `#define ${e}\n`).join("")}${ht}`;
}
var ht = "precision highp float;\nprecision highp int;\nprecision highp sampler2D;\nuniform sampler2D front;    // place, angle in degrees (< 0: none), radiance\nuniform sampler2D back;\nuniform sampler2D behind;   // radiance, share covered by film\nuniform sampler2D field;    // thickness in nm of a cell, the one after it, the one below, the one below and after\nuniform sampler2D values;   // X, Y, Z at the nodes of the table\nuniform sampler2D slopes;\nuniform highp usampler2D draft; // for what moves: X, Y, Z of a node and of the next as six halves\nuniform vec4 draft_axes;    // first reduced thickness, 1 / step; first angle, 1 / step\nuniform ivec2 size;         // of the table: columns, rows\nuniform vec4 axes;          // first reduced thickness, step; first angle, step\nuniform vec4 limits;        // thickness from, to; angle from, to\nuniform float inverse_square;\nuniform vec3 white;\nuniform vec3 over_white;    // 1 / white\nuniform mat3 rgb_from_xyz;\nuniform float exposure;\nout vec4 color;\n\n// One texel a place: fetches are most of what a picture costs where there is no graphics device.\nfloat thickness_at(vec2 place) {\n  ivec2 cells = textureSize(field, 0);\n  place.x = fract(place.x);\n#ifdef REPEATS\n  place.y = fract(place.y);\n#endif\n  vec2 p = place * vec2(cells) - 0.5;\n#ifndef REPEATS\n  p.y = clamp(p.y, 0.0, float(cells.y - 1));\n#endif\n  vec2 low = floor(p);\n  vec2 f = p - low;\n  ivec2 cell = ivec2(low);\n  if (cell.x < 0) cell.x += cells.x;\n  if (cell.y < 0) cell.y += cells.y;\n  vec4 corners = texelFetch(field, cell, 0);\n  vec2 rows = mix(corners.xz, corners.yw, f.x);\n  return mix(rows.x, rows.y, f.y);\n}\n\n// sin^2 of an angle in degrees from 0 to 90, by a polynomial: what a driver's own sine is worth is not said anywhere.\nfloat sin_squared(float degrees) {\n  float x = degrees * 0.017453292519943295;\n  bool large = x > 0.7853981633974483;\n  if (large) x = 1.5707963267948966 - x;\n  float y = x * x;\n  float s = x * (1.0 + y * (-0.16666666667 + y * (0.00833333333 + y * (-0.000198412698 + y * 2.7557319e-6))));\n  return large ? 1.0 - s * s : s * s;\n}\n\nvec3 film(float nm, float degrees) {\n  float angle = clamp(degrees, limits.z, limits.w);\n  float v = clamp(nm, limits.x, limits.y) * sqrt(1.0 - sin_squared(angle) * inverse_square);\n#ifdef DRAFT\n  ivec2 last = textureSize(draft, 0) - 1;\n  float p = clamp((v - draft_axes.x) * draft_axes.y, 0.0, float(last.x));\n  float low = floor(p);\n  uvec4 six = texelFetch(draft, ivec2(int(low), min(int((angle - draft_axes.z) * draft_axes.w + 0.5), last.y)), 0);\n  vec2 middle = unpackHalf2x16(six.y);\n  return mix(vec3(unpackHalf2x16(six.x), middle.x), vec3(middle.y, unpackHalf2x16(six.z)), p - low);\n#else\n  float p = max((v - axes.x) / axes.y, 0.0);\n  int column = int(min(floor(p), float(size.x - 2)));\n  float f = p - float(column);\n  float g = 1.0 - f;\n  vec4 along = vec4((f * 2.0 + 1.0) * g * g, f * g * g, f * f * (3.0 - 2.0 * f), -(f * f * g));\n  int row = 0;\n  vec4 across = vec4(1.0, 0.0, 0.0, 0.0);\n  if (size.y > 1) {\n    float y = (angle - axes.z) / axes.w;\n    row = int(clamp(floor(y) - 1.0, 0.0, float(size.y - 4)));\n    float a = y - float(row);\n    float b = a - 1.0, c = a - 2.0, d = a - 3.0;\n    across = vec4(b * c * d / -6.0, a * c * d / 2.0, a * b * d / -2.0, a * b * c / 6.0);\n  }\n  vec3 sum = vec3(0.0);\n  int rows = size.y > 1 ? 4 : 1;\n  for (int k = 0; k < rows; k++) {\n    ivec2 here = ivec2(column, row + k);\n    ivec2 next = here + ivec2(1, 0);\n    sum += across[k] * (along.x * texelFetch(values, here, 0).xyz + along.y * texelFetch(slopes, here, 0).xyz\n      + along.z * texelFetch(values, next, 0).xyz + along.w * texelFetch(slopes, next, 0).xyz);\n  }\n  return sum;\n#endif\n}\n\nvec3 wall(vec4 w) {\n#ifdef FIELD\n  return film(thickness_at(w.xy), w.z);\n#else\n  return film(w.x, w.z);\n#endif\n}\n\n// The sRGB curve of 0 to 1 to 0.01 of a step of eight bits, by roots: x^(1/2.4) itself takes a logarithm and a power.\n// The numbers are a least-squares fit of 1.055 x^(1/2.4) - 0.055 over 0.0031308 to 1, its largest error weighed down.\nvec3 curve(vec3 x) {\n  vec3 s = sqrt(x);\n  vec3 q = sqrt(s);\n  vec3 high = 0.6539859249 * s + 0.6887108621 * q - 0.3184722845 * sqrt(q) - 0.0201880726 * x - 0.0040677372;\n  return mix(high, 12.92 * x, vec3(lessThanEqual(x, vec3(0.0031308))));\n}\n\nvoid main() {\n  ivec2 pixel = ivec2(gl_FragCoord.xy);\n#ifndef ANSWER\n  // The first row of the pixels is at the bottom of the screen.\n  pixel.y = textureSize(front, 0).y - 1 - pixel.y;\n#endif\n  vec4 near = texelFetch(front, pixel, 0);\n  vec2 rest = texelFetch(behind, pixel, 0).xy;\n  vec3 xyz = white * rest.x;\n  if (near.z >= 0.0) {\n    vec3 mirrored = wall(near);\n    vec3 seen = mirrored * near.w;\n#ifdef PASSES\n    vec3 through = 1.0 - mirrored * over_white;\n    vec4 far = texelFetch(back, pixel, 0);\n    vec3 beyond = white * rest.x;\n    if (far.z >= 0.0) {\n      vec3 inner = wall(far);\n      beyond = beyond * (1.0 - inner * over_white) + inner * through * far.w;\n    }\n    seen += beyond * through;\n#endif\n    xyz = mix(xyz, seen, rest.y);\n  }\n#ifdef ANSWER\n  color = vec4(xyz, 1.0);\n#else\n  vec3 rgb = rgb_from_xyz * xyz * exposure;\n  float luminance = clamp(xyz.y * exposure, 0.0, 1.0);\n  // Towards the grey of the same luminance until all fit: hue stays.\n  float least = min(rgb.x, min(rgb.y, rgb.z));\n  if (least < 0.0) rgb = luminance + (rgb - luminance) * luminance / max(luminance - least, 1e-9);\n  float most = max(rgb.x, max(rgb.y, rgb.z));\n  if (most > 1.0) rgb = luminance + (rgb - luminance) * (1.0 - luminance) / max(most - luminance, 1e-9);\n  rgb = clamp(rgb, 0.0, 1.0);\n  color = vec4(curve(rgb), 1.0);\n#endif\n}", gt = {
	columns: 1,
	rows: 1,
	thickness_nm: /* @__PURE__ */ new Float32Array(1)
}, _t = class {
	constructor(e, t, n = !1) {
		if (this.canvas = e, this.painter = null, this.drawn = "", this.geometry = null, this.table = null, this.field = gt, this.look = {
			rgb_from_xyz: [
				1,
				0,
				0,
				0,
				1,
				0,
				0,
				0,
				1
			],
			exposure: 1,
			moving: !1
		}, n) this.painter = new Et(e);
		else try {
			this.painter = new vt(e, t);
		} catch (n) {
			console.info(`WebGL2 cannot be used: ${n instanceof Error ? n.message : n}`), e.getContext("webgl2") ? queueMicrotask(t) : this.painter = new Et(e);
		}
	}
	get kind() {
		return this.painter?.kind ?? "canvas";
	}
	get software() {
		return this.painter?.software ?? !0;
	}
	setGeometry(e) {
		this.geometry = e, this.canvas.width !== e.width && (this.canvas.width = e.width), this.canvas.height !== e.height && (this.canvas.height = e.height), this.painter?.setGeometry(e), this.drawn = "";
	}
	setTable(e) {
		this.table !== e && (this.table = e, this.painter?.setTable(e), this.drawn = "");
	}
	setField(e) {
		this.field = e, this.painter?.setField(e), this.drawn = "";
	}
	draw() {
		if (!this.geometry || !this.table || !this.painter) return !1;
		let e = `${this.look.exposure} ${this.look.moving}`;
		return e !== this.drawn && this.painter.draw(this.look), this.drawn = e, !0;
	}
	at(e, t) {
		let n = this.geometry;
		if (!n || e < 0 || t < 0 || e >= n.width || t >= n.height) return null;
		let r = (t * n.width + e) * 4, [i, a, o] = n.front.subarray(r, r + 3);
		return o < 0 ? null : {
			thickness_nm: n.field ? it(this.field, i, a, n.repeats) : i,
			angle_deg: o,
			place: [i, a]
		};
	}
	pixels() {
		let e = this.geometry;
		if (!e || !this.table || !this.painter) return null;
		let t = e.width * e.height, [n, r] = [new Float32Array(t).fill(NaN), new Float32Array(t).fill(NaN)];
		for (let i = 0; i < t; i++) {
			let t = i * 4;
			e.front[t + 2] < 0 || (r[i] = e.front[t + 2], n[i] = e.field ? it(this.field, e.front[t], e.front[t + 1], e.repeats) : e.front[t]);
		}
		return {
			width: e.width,
			height: e.height,
			xyz: this.painter.xyz(),
			thickness_nm: n,
			angle_deg: r
		};
	}
	luminances() {
		let { geometry: e, table: t } = this;
		if (!e || !t) return [];
		let n = [], r = /* @__PURE__ */ new Float32Array(3), i = e.width * e.height, a = Math.max(1, Math.floor(i / 4e3)) | 1;
		for (let o = 0; o < i; o += a) e.front[o * 4 + 2] < 0 || (Ct(e, t, this.field, o, r, 0), n.push(r[1]));
		return n.sort((e, t) => e - t);
	}
	dispose() {
		this.painter?.dispose();
	}
}, Z = [
	"front",
	"back",
	"behind",
	"field",
	"values",
	"slopes",
	"draft"
], vt = class {
	constructor(e, t) {
		this.canvas = e, this.kind = "webgl2", this.programs = /* @__PURE__ */ new Map(), this.textures = /* @__PURE__ */ new Map(), this.held = /* @__PURE__ */ new Map(), this.corners = /* @__PURE__ */ new Float32Array(), this.geometry = null, this.table = null, this.drafted = null, this.hasDraft = !1, this.draftAxes = [
			0,
			1,
			0,
			1
		];
		let n = e.getContext("webgl2", {
			antialias: !1,
			alpha: !1,
			preserveDrawingBuffer: !0,
			desynchronized: !0
		});
		if (!n) throw Error("no WebGL2 here");
		this.gl = n;
		let r = n.getExtension("WEBGL_debug_renderer_info")?.UNMASKED_RENDERER_WEBGL ?? n.RENDERER;
		this.software = /swiftshader|llvmpipe|softpipe|basic render/i.test(String(n.getParameter(r))), this.program([]), Z.forEach((e, t) => {
			let r = n.createTexture();
			if (!r) throw Error("no texture");
			n.activeTexture(n.TEXTURE0 + t), n.bindTexture(n.TEXTURE_2D, r);
			for (let e of [n.TEXTURE_MIN_FILTER, n.TEXTURE_MAG_FILTER]) n.texParameteri(n.TEXTURE_2D, e, n.NEAREST);
			this.textures.set(e, r);
		}), this.setField(gt), this.lost = (e) => {
			e.preventDefault(), t();
		}, e.addEventListener("webglcontextlost", this.lost);
	}
	program(e) {
		let t = e.join(" "), n = this.programs.get(t);
		return n || (n = new yt(this.gl, e), this.programs.set(t, n)), n;
	}
	fill(e, t, n, r, i) {
		let a = this.gl, o = a.getParameter(a.MAX_TEXTURE_SIZE);
		if (t > o || n > o) throw Error(`${e} needs ${t} x ${n}, ${o} is the most`);
		let [s, c] = [
			[a.R32F, a.RED],
			[a.RG32F, a.RG],
			[a.RGB32F, a.RGB],
			[a.RGBA32F, a.RGBA]
		][r - 1];
		a.activeTexture(a.TEXTURE0 + Z.indexOf(e)), a.bindTexture(a.TEXTURE_2D, this.textures.get(e)), a.pixelStorei(a.UNPACK_ALIGNMENT, 4);
		let l = `${t} ${n} ${r}`;
		this.held.get(e) === l ? a.texSubImage2D(a.TEXTURE_2D, 0, 0, 0, t, n, c, a.FLOAT, i) : a.texImage2D(a.TEXTURE_2D, 0, s, t, n, 0, c, a.FLOAT, i), this.held.set(e, l);
	}
	setGeometry(e) {
		let t = this.gl;
		this.geometry = e, this.fill("front", e.width, e.height, 4, e.front), e.passes ? this.fill("back", e.width, e.height, 4, e.back) : this.fill("back", 1, 1, 4, /* @__PURE__ */ new Float32Array(4)), this.fill("behind", e.width, e.height, 2, e.behind), t.viewport(0, 0, e.width, e.height);
	}
	fillDraft({ rows: e, columns: t, texels: n, axes: r }) {
		let i = this.gl;
		i.activeTexture(i.TEXTURE0 + Z.indexOf("draft")), i.bindTexture(i.TEXTURE_2D, this.textures.get("draft")), i.texImage2D(i.TEXTURE_2D, 0, i.RGBA32UI, t, e, 0, i.RGBA_INTEGER, i.UNSIGNED_INT, n), this.draftAxes = [
			r[0],
			1 / r[1],
			r[2],
			1 / r[3]
		];
	}
	draftReady() {
		if (this.drafted === this.table || !this.table) return this.hasDraft;
		this.drafted = this.table;
		let e = ct(this.table);
		return this.hasDraft = !!e, e && this.fillDraft(e), this.hasDraft;
	}
	setTable(e) {
		this.table = e;
		let { rows: t, columns: n, nodes: r } = e, i = t * n, [a, o] = [new Float32Array(i * 3), new Float32Array(i * 3)];
		for (let e = 0; e < i; e++) for (let t = 0; t < 3; t++) a[3 * e + t] = r[6 * e + t], o[3 * e + t] = r[6 * e + 3 + t];
		this.fill("values", n, t, 3, a), this.fill("slopes", n, t, 3, o);
	}
	setField(e) {
		let { columns: t, rows: n, thickness_nm: r } = e;
		this.corners.length !== t * n * 4 && (this.corners = new Float32Array(t * n * 4));
		let { corners: i } = this;
		for (let e = 0; e < n; e++) {
			let [a, o] = [e * t, (e + 1) % n * t];
			for (let e = 0; e < t; e++) {
				let n = e + 1 < t ? e + 1 : 0, s = 4 * (a + e);
				i[s] = r[a + e], i[s + 1] = r[a + n], i[s + 2] = r[o + e], i[s + 3] = r[o + n];
			}
		}
		this.fill("field", t, n, 4, i);
	}
	run(e, t) {
		let { gl: n, table: r } = this, i = this.geometry;
		if (!r) return;
		let a = {
			FIELD: i.field,
			REPEATS: i.repeats,
			PASSES: i.passes,
			DRAFT: e.moving && this.draftReady(),
			ANSWER: t
		}, o = this.program(ft.filter((e) => a[e]));
		o.use(), n.uniform2i(o.place("size"), r.columns, r.rows), n.uniform4f(o.place("axes"), r.first_nm, r.step_nm, r.first_deg, r.step_deg), n.uniform4f(o.place("limits"), ...r.range_nm, ...r.range_deg), n.uniform1f(o.place("inverse_square"), r.inverse_square);
		let [s, c, l] = r.white;
		n.uniform3f(o.place("white"), s, c, l), n.uniform3f(o.place("over_white"), 1 / s, 1 / c, 1 / l), n.uniform4f(o.place("draft_axes"), ...this.draftAxes), n.uniformMatrix3fv(o.place("rgb_from_xyz"), !0, Float32Array.from(e.rgb_from_xyz)), n.uniform1f(o.place("exposure"), e.exposure), n.drawArrays(n.TRIANGLES, 0, 3);
	}
	draw(e) {
		this.geometry && this.run(e, !1);
	}
	xyz() {
		let e = this.gl, { width: t, height: n } = this.geometry;
		if (!e.getExtension("EXT_color_buffer_float")) throw Error("this device draws no floats");
		let r = e.createRenderbuffer(), i = e.createFramebuffer();
		e.bindRenderbuffer(e.RENDERBUFFER, r), e.renderbufferStorage(e.RENDERBUFFER, e.RGBA32F, t, n), e.bindFramebuffer(e.FRAMEBUFFER, i), e.framebufferRenderbuffer(e.FRAMEBUFFER, e.COLOR_ATTACHMENT0, e.RENDERBUFFER, r), this.run({
			rgb_from_xyz: [
				1,
				0,
				0,
				0,
				1,
				0,
				0,
				0,
				1
			],
			exposure: 1,
			moving: !1
		}, !0);
		let a = new Float32Array(t * n * 4);
		e.readPixels(0, 0, t, n, e.RGBA, e.FLOAT, a), e.bindFramebuffer(e.FRAMEBUFFER, null), e.deleteFramebuffer(i), e.deleteRenderbuffer(r);
		let o = new Float32Array(t * n * 3);
		for (let e = 0; e < t * n; e++) o.set(a.subarray(4 * e, 4 * e + 3), 3 * e);
		return o;
	}
	dispose() {
		this.canvas.removeEventListener("webglcontextlost", this.lost);
		for (let e of this.textures.values()) this.gl.deleteTexture(e);
		for (let e of this.programs.values()) e.dispose();
	}
}, yt = class {
	constructor(e, t) {
		this.gl = e, this.places = /* @__PURE__ */ new Map(), this.program = bt(e, mt(t)), e.useProgram(this.program), Z.forEach((t, n) => e.uniform1i(this.place(t), n));
	}
	use() {
		this.gl.useProgram(this.program);
	}
	place(e) {
		return this.places.has(e) || this.places.set(e, this.gl.getUniformLocation(this.program, e)), this.places.get(e) ?? null;
	}
	dispose() {
		this.gl.deleteProgram(this.program);
	}
};
function bt(e, t) {
	let n = e.createProgram();
	if (!n) throw Error("no program");
	for (let [r, i] of [[e.VERTEX_SHADER, pt], [e.FRAGMENT_SHADER, t]]) {
		let t = e.createShader(r);
		if (!t) throw Error("no shader");
		if (e.shaderSource(t, i), e.compileShader(t), !e.getShaderParameter(t, e.COMPILE_STATUS)) throw Error(e.getShaderInfoLog(t) ?? "a shader");
		e.attachShader(n, t);
	}
	if (e.linkProgram(n), !e.getProgramParameter(n, e.LINK_STATUS)) throw Error(e.getProgramInfoLog(n) ?? "the program");
	return n;
}
var xt = /* @__PURE__ */ new Float64Array(3), St = /* @__PURE__ */ new Float64Array(3);
function Ct(e, t, n, r, i, a) {
	let { front: o, back: s, behind: c, passes: l } = e, u = r * 4, [d, f] = [c[2 * r], c[2 * r + 1]], p = o[u + 2] >= 0, m = p && l && s[u + 2] >= 0;
	p && wt(e, t, n, o, u, xt), m && wt(e, t, n, s, u, St);
	for (let e = 0; e < 3; e++) {
		let n = t.white[e], r = n * d;
		if (p) {
			let t = xt[e] * o[u + 3];
			if (l) {
				let r = 1 - xt[e] / n, i = n * d;
				m && (i = i * (1 - St[e] / n) + St[e] * r * s[u + 3]), t += i * r;
			}
			r += (t - r) * f;
		}
		i[a + e] = r;
	}
}
function wt(e, t, n, r, i, a) {
	ke(t, e.field ? it(n, r[i], r[i + 1], e.repeats) : r[i], r[i + 2], a, 0);
}
function Tt(e, t, n, r, i, a) {
	let o = r.rgb_from_xyz, s = r.exposure, c = [
		0,
		3,
		6
	].map((r) => (o[r] * e + o[r + 1] * t + o[r + 2] * n) * s), l = Math.min(Math.max(t * s, 0), 1), u = Math.min(...c), d = u < 0 ? l / Math.max(l - u, 1e-9) : 1, f = c.map((e) => l + (e - l) * d), p = Math.max(...f), m = p > 1 ? (1 - l) / Math.max(p - l, 1e-9) : 1;
	for (let e = 0; e < 3; e++) {
		let t = Math.min(Math.max(l + (f[e] - l) * m, 0), 1);
		i[a + e] = 255 * (t <= .0031308 ? 12.92 * t : 1.055 * t ** (1 / 2.4) - .055);
	}
}
var Et = class {
	constructor(e) {
		this.kind = "canvas", this.software = !0, this.geometry = null, this.table = null, this.field = gt;
		let t = e.getContext("2d");
		if (!t) throw Error("this browser has no canvas");
		this.context = t;
	}
	setGeometry(e) {
		this.geometry = e;
	}
	setTable(e) {
		this.table = e;
	}
	setField(e) {
		this.field = e;
	}
	draw(e) {
		if (!this.geometry || !this.table) return;
		let { width: t, height: n } = this.geometry, r = this.context.createImageData(t, n), i = /* @__PURE__ */ new Float32Array(3);
		for (let a = 0; a < t * n; a++) Ct(this.geometry, this.table, this.field, a, i, 0), Tt(i[0], i[1], i[2], e, r.data, 4 * a), r.data[4 * a + 3] = 255;
		this.context.putImageData(r, 0, 0);
	}
	xyz() {
		let e = this.geometry, t = e.width * e.height, n = new Float32Array(t * 3);
		for (let r = 0; r < t; r++) Ct(e, this.table, this.field, r, n, 3 * r);
		return n;
	}
	dispose() {
		this.geometry = null;
	}
};
function Dt(e) {
	return [
		"zeroth",
		"first",
		"second",
		"third",
		"fourth",
		"fifth",
		"sixth",
		"seventh",
		"eighth"
	][e] ?? `${e}th`;
}
var Q = {
	title: "iridesce",
	tagline: "interference colour, computed exactly",
	skip: "Skip to the content",
	scenes_of: "Scenes",
	scenes: {
		bubble: "Soap bubble",
		rings: "Newton's rings",
		slick: "Oil slick",
		titanium: "Titanium",
		wafer: "Wafer",
		film: "Any film",
		learn: "Learn"
	},
	about: {
		bubble: "A soap film from its physics: gravity sorts it by thickness, air stirs it, it drains and dries. Drag across the picture to blow on it.",
		rings: "The gap of air under a long-focus lens that rests on glass, seen straight from above. The lens's upper face is bloomed and still mirrors about 1.3 %: that veil is why the centre is dark grey, not black.",
		slick: "Oil of index 1.47 on still water. Where the film is thinnest it has no colour; the bands repeat as it thickens, and pale.",
		titanium: "Titanium wears a film of its oxide; anodising thickens it by 2.4 nm a volt. No dye is in it.",
		wafer: "Silicon with a film of its oxide, as chip makers read it: the colour tells the thickness.",
		film: "Any stack of layers: across the picture its thickness grows, downwards the angle. Click to look closer.",
		learn: "Six short stories, each a state of this page with a question and its answer."
	},
	keys: {
		stack: "Stack",
		thickness_nm: "Thickness",
		angle_deg: "Angle of view",
		illuminant: "Lamp",
		preset: "Film",
		playing: "Flowing",
		age_s: "Age at the start",
		wind_m_s: "Wind",
		gravity_m_s2: "Gravity",
		walls: "Walls",
		seed: "Another film (seed)",
		radius_mm: "Radius of the lens",
		view_mm: "Width of the view",
		volts: "Voltage",
		edge_nm: "Thickness at the edge",
		thickest_nm: "Chart up to",
		model: "Model of the chart below",
		environment: "Surroundings",
		exposure: "Exposure"
	},
	keysOf: {
		"bubble thickness_nm": "Mean thickness at the start",
		"rings thickness_nm": "Gap at the centre",
		"slick thickness_nm": "Thickest place",
		"titanium thickness_nm": "Oxide",
		"wafer thickness_nm": "Thickness in the middle"
	},
	help: {
		stack: "items separated by \" / \", light comes from the left: a name, a number or n+kj; layers add their nm; ? is the layer that varies",
		exposure: "added to the exposure that the page finds",
		radius_mm: "a flatter lens has wider rings"
	},
	choices: {
		"free-bubble-preview": "free bubble",
		"bubble-on-bath-preview": "dome on water",
		"late-preview": "old dome, black film",
		"vertical-film-preview": "film in a frame",
		still: "still, thickening downwards",
		2: "both",
		1: "the front one only",
		D65: "daylight (D65)",
		A: "light bulb (A)",
		D50: "warm daylight (D50)",
		E: "equal energy (E)",
		FL2: "fluorescent tube (FL2)",
		FL11: "three-band tube (FL11)",
		"LED-B1": "white LED (LED-B1)",
		"blackbody:4000": "glowing, 4000 K",
		"lines:589.158*2,589.756": "sodium lamp",
		"lines:546.227,404.77,435.96,577.12,579.23": "mercury lines",
		"laser:632.99": "red laser",
		exact: "exact",
		"two-beam": "two beams (1991)",
		studio: "studio with a window",
		overcast: "overcast sky",
		uniform: "white all round",
		auto: "as the system",
		light: "light",
		dark: "dark"
	},
	controls: "Controls",
	play: "Let it flow",
	pause: "Pause",
	again: "A new film",
	blow: "Blow on it",
	save_picture: "Save the picture",
	save_csv: "Save numbers (CSV)",
	copy_link: "Copy the link",
	copied: "The link is on the clipboard.",
	reset: "Reset",
	theme: "Theme",
	pointer: "Under the pointer",
	film_here: "This film",
	spectrum: "Spectrum",
	spectrum_of: (e) => `Reflectance of ${e} over wavelength`,
	table_under: "The numbers",
	diagram: "Path in the CIE diagram",
	diagram_of: (e) => `Chromaticity of the film as it thickens from 0 to ${e} nm; rainbow colours lie on the curved line`,
	newton: "Newton's scale",
	newton_of: (e) => `Colours of the film from 0 to ${e} nm at normal incidence; roman numbers: where its orders end`,
	strip: "All angles",
	strip_of: (e) => `Colours of a film of ${e} nm from 0 to 80 degrees`,
	compare: "Exact, and the model of 1991",
	compare_note: (e) => `The two differ by CIEDE2000 ${e}.`,
	no_two_beam: "The model of 1991 knows one transparent layer at angles without total reflection; this stack is another.",
	rings_measured: "Rings",
	rings_table: "Radii of dark rings in mm: by the formula r = √(m λ R), and measured in this picture (minima of luminance along a radius)",
	ring: "ring",
	told: "formula",
	measured: "measured",
	reflectance: "reflectance",
	order: (e) => `${Dt(e)} order`,
	seen: (e, t, n, r) => `film ${e} nm at ${t} degrees: ${n}${r ? `, ${r}` : ""}`,
	bubble_facts: (e, t, n, r) => `${e} s old; thickness ${n} to ${r} nm, mean ${t} nm`,
	slick_seen: (e, t) => `oil from 20 to ${e} nm thick under ${t}`,
	still_seen: (e, t) => `film from 0 nm at the top to ${e} nm at the bottom under ${t}`,
	rings_seen: (e, t, n) => `the centre is ${e}${t ? `; dark rings at ${t} mm` : ""}, under ${n}`,
	burst: (e) => `It burst after ${e} s.`,
	table_error: (e) => `Colours are within CIEDE2000 ${e} of the exact sums.`,
	renderer: {
		webgl2: "Drawn with WebGL2.",
		canvas: "Drawn without WebGL, more slowly."
	},
	lost: "The graphics device was lost. The page goes on drawing without it, more slowly.",
	slow: "This browser offers no WebGL2. The page draws without it, more slowly.",
	cannot: (e) => `This cannot be drawn: ${e}`,
	no_start: (e) => `The page could not start: ${e}`,
	left_out: "From the link was left out:",
	colors: {
		black: "black",
		white: "white",
		light_grey: "light grey",
		grey: "grey",
		dark_grey: "dark grey",
		pale: "pale",
		very_dark: "very dark",
		greyish: "greyish",
		dark: "dark",
		dull: "dull",
		vivid: "vivid",
		light: "light"
	},
	learn: {
		question: "Question",
		answer: "Answer",
		show: "Show the answer",
		look: "Look",
		before: "Before",
		next: "Next",
		all: "All stories",
		sheet: "Print a worksheet",
		sheet_title: "Worksheet: colours of thin films",
		sheet_key: "Answer key",
		sheet_name: "Name",
		sheet_new: "Other numbers",
		sheet_back: "Back to the page",
		sheet_print: "Print",
		sheet_for: "Numbers by the iridesce core; colours are exact spectral sums under D65, CIE 1931 2 degree observer."
	},
	footer: "Nothing leaves this page: no cookies, no requests. Rust core in WebAssembly; the same digits as the iridesce package."
}, $ = {
	width: 360,
	height: 190,
	left: 42,
	right: 8,
	top: 10,
	bottom: 30
};
function Ot(e) {
	let t = 10 ** Math.floor(Math.log10(Math.max(e, 1e-4)));
	return [
		1,
		2,
		2.5,
		5,
		10
	].map((e) => e * t).find((t) => t >= e) ?? e;
}
function kt(e, t, n) {
	let [r, i] = [t[0], t[t.length - 1]], a = 0;
	for (let e of n) for (let t = 0; t < e.values.length; t++) a = Math.max(a, e.values[t]);
	let o = Ot(a), s = (e) => $.left + (e - r) / (i - r) * ($.width - $.left - $.right), c = (e) => $.height - $.bottom - e / o * ($.height - $.top - $.bottom), l = (e) => Array.from(e, (e, n) => `${n ? "L" : "M"}${s(t[n]).toFixed(1)} ${c(e).toFixed(1)}`).join(""), u = [
		400,
		500,
		600,
		700,
		800
	].filter((e) => e >= r && e <= i), d = [
		0,
		.25,
		.5,
		.75,
		1
	].map((e) => e * o);
	return M`<figure class="chart">
    <svg viewBox="0 0 ${$.width} ${$.height}" role="img" aria-label=${e}>
      <defs>
        <linearGradient id="rainbow">
          ${At.map(([e, t]) => pe`<stop offset=${(e - r) / (i - r)} stop-color=${t}></stop>`)}
        </linearGradient>
      </defs>
      <rect x=${$.left} y=${$.height - $.bottom} width=${$.width - $.left - $.right} height="5" fill="url(#rainbow)"></rect>
      ${d.map((e) => pe`<line class="grid" x1=${$.left} x2=${$.width - $.right} y1=${c(e)} y2=${c(e)}></line>
          <text x=${$.left - 5} y=${c(e) + 4} text-anchor="end">${String(Number((100 * e).toPrecision(3)))}%</text>`)}
      ${u.map((e) => pe`<text x=${s(e)} y=${$.height - 8} text-anchor="middle">${e} nm</text>`)}
      ${n.map((e) => pe`<path class="curve ${e.kind}" d=${l(e.values)}></path>`)}
    </svg>
    ${n.length > 1 ? M`<figcaption>${n.map((e) => M`<span class="key ${e.kind}">${e.name}</span>`)}</figcaption>` : ""}
    <details>
      <summary>${Q.table_under}</summary>
      <table>
        <caption>${e}</caption>
        <thead><tr><th scope="col">nm</th>${n.map((e) => M`<th scope="col">${e.name}</th>`)}</tr></thead>
        <tbody>
          ${Array.from(t).map((e, t) => [e, t]).filter(([e]) => Math.abs(e % 20) < 1e-9).map(([e, t]) => M`<tr><th scope="row">${e}</th>${n.map((e) => M`<td>${e.values[t].toFixed(4)}</td>`)}</tr>`)}
        </tbody>
      </table>
    </details>
  </figure>`;
}
var At = [
	[390, "#2a0052"],
	[430, "#3300cc"],
	[470, "#0066ff"],
	[500, "#00b386"],
	[530, "#1fb800"],
	[570, "#c8c800"],
	[600, "#ff8000"],
	[640, "#e60000"],
	[700, "#8c0000"],
	[770, "#2e0000"]
], jt = 360, Mt = 60, Nt = 2;
function Pt(e) {
	return e instanceof DataView ? new Float32Array(e.buffer.slice(e.byteOffset, e.byteOffset + e.byteLength)) : /* @__PURE__ */ new Float32Array();
}
function Ft(e) {
	let t = e.get("_shape"), n = Pt(e.get("_nodes"));
	if (t.length < 8 || n.length !== t[0] * t[1] * 6) return null;
	let [r, i, a, o, s, c, l, u] = [
		t[0],
		t[1],
		t[2],
		t[3],
		t[4],
		t[5],
		t[6],
		t[7]
	];
	return {
		rows: r,
		columns: i,
		first_nm: 0,
		step_nm: a / (i - 1),
		first_deg: 0,
		step_deg: o / (r - 1),
		inverse_square: 0,
		white: [
			s,
			c,
			l
		],
		max_delta_e: u,
		mean_delta_e: u,
		range_nm: [0, a],
		range_deg: [0, o],
		nodes: n
	};
}
function It(e) {
	return e.get("_matrix");
}
function Lt({ model: e, el: t }) {
	let n = e.get("kind"), r = document.createElement("div");
	r.className = "iridesce-widget", t.append(r);
	let i = document.createElement("canvas");
	i.width = i.height = jt, i.setAttribute("role", "img");
	let a = new _t(i, () => d()), o = document.createElement("div"), s = document.createElement("div"), c = document.createElement("div");
	c.className = "iridesce-seen", c.append(a.canvas), r.append(c, o, s);
	let l = () => {
		let t = n === "film" ? Math.round(jt * 4 / 3) : jt, r = { ...Ge(n === "film" ? "film" : "bubble") };
		n === "film" ? r.thickest_nm = e.get("_shape")[2] ?? 1200 : r.preset = "free-bubble-preview", a.setGeometry(rt({
			width: t,
			height: jt,
			state: r,
			water: () => /* @__PURE__ */ new Float64Array(91)
		}));
	}, u = () => {
		if (n !== "bubble") return;
		let [t, r] = e.get("_field_size"), i = Pt(e.get("_field"));
		if (i.length !== t * r) return;
		let o = e.get("thickness_nm");
		a.setField({
			columns: t,
			rows: r,
			thickness_nm: i.map((e) => e * o)
		});
	}, d = () => {
		a.canvas.parentElement !== c && c.prepend(a.canvas);
		let t = a.luminances(), r = t[Math.floor(t.length * (n === "bubble" ? .96 : .995))] || 1;
		a.look = {
			rgb_from_xyz: It(e),
			moving: !1,
			exposure: .82 / r
		}, a.draw(), a.canvas.setAttribute("aria-label", String(e.get("_words")));
	}, f, p = (t, n) => {
		e.set(t, n), clearTimeout(f), f = setTimeout(() => e.save_changes(), Mt);
	}, m = () => {
		let [t, r, i] = [
			e.get("thickness_nm"),
			e.get("angle_deg"),
			e.get("illuminant")
		], a = e.get("_shape")[2] ?? 1200, c = Be.includes(i) ? Be : [...Be, i];
		Te(M`<label>${n === "bubble" ? Q.keysOf["bubble thickness_nm"] : Q.keys.thickness_nm}
          <input type="range" min="0" max=${n === "bubble" ? Math.floor(a / 2) : a} step="1" .value=${String(t)} @input=${(e) => p("thickness_nm", e.target.valueAsNumber)} />
          <output>${t.toFixed(0)} nm</output></label>
        <label>${Q.keys.angle_deg}
          <input type="range" min="0" max=${80} step="1" .value=${String(r)} @input=${(e) => p("angle_deg", e.target.valueAsNumber)} />
          <output>${r.toFixed(0)}°</output></label>
        <label>${Q.keys.illuminant}
          <select @change=${(e) => p("illuminant", e.target.value)}>
            ${c.map((e) => M`<option value=${e} ?selected=${e === i}>${Q.choices[e] ?? e}</option>`)}
          </select></label>
        <p><span class="iridesce-swatch"></span> ${e.get("_words")}</p>`, o);
		let l = o.querySelector(".iridesce-swatch");
		l && (l.style.backgroundColor = String(e.get("_srgb")));
		let u = Pt(e.get("_spectrum"));
		if (u.length > 1) {
			let t = Float64Array.from(u, (e, t) => je[0] + Nt * t);
			Te(kt(String(e.get("_words")), t, [{
				name: Q.reflectance,
				kind: "first",
				values: u
			}]), s);
		}
	}, h = [
		["change:_nodes", () => {
			g(), d(), m();
		}],
		["change:_field", () => {
			u(), d();
		}],
		["change:thickness_nm", () => {
			u(), d(), m();
		}],
		["change:angle_deg", m],
		["change:illuminant", m],
		["change:_words", () => {
			m(), d();
		}],
		["change:_spectrum", m]
	], g = () => {
		let t = Ft(e);
		t && a.setTable(t), l();
	};
	g(), u(), d(), m();
	for (let [t, n] of h) e.on(t, n);
	return () => {
		clearTimeout(f);
		for (let [t, n] of h) e.off(t, n);
		a.dispose(), r.remove();
	};
}
function Rt(e, t, n) {
	let r = Ft(e), i = /* @__PURE__ */ new Float64Array(3);
	return r && ke(r, t, n, i, 0), Array.from(i);
}
var zt = { render: Lt };
export { Rt as colorAt, zt as default };
