// Stories and worksheets as they stand in the page.

import { html, nothing, type TemplateResult } from "lit";
import type { Page } from "../page";
import { TEXT } from "../text/strings";
import { STORIES, type Story } from "./stories";
import { worksheet } from "./worksheet";

/** A story beside its picture. */
export function storyPanel(page: Page, story: Story, number: number): TemplateResult {
  return html`<section class="story" aria-label=${story.title}>
    <h2>${number}. ${story.title}</h2>
    <p><b>${TEXT.learn.look}:</b> ${story.look}</p>
    <p><b>${TEXT.learn.question}:</b> ${story.question}</p>
    ${page.answerShown && page.core
      ? html`<p class="answer" role="status"><b>${TEXT.learn.answer}:</b> ${story.answer(page.core)}</p>`
      : html`<p><button type="button" class="main" @click=${() => page.showAnswer()}>${TEXT.learn.show}</button></p>`}
    <p class="tools">
      ${number > 1 ? html`<a href=${STORIES[number - 2].link}>${TEXT.learn.before}</a>` : nothing}
      ${number < STORIES.length ? html`<a href=${STORIES[number].link}>${TEXT.learn.next}</a>` : nothing}
      <a href="#v=1&scene=learn">${TEXT.learn.all}</a>
    </p>
  </section>`;
}

export function learnPage(page: Page): TemplateResult {
  const sheet = Number(page.state["sheet"]);
  if (sheet > 0 && page.core) {
    const exercises = worksheet(page.core, sheet);
    return html`<article class="sheet">
      <h1>${TEXT.learn.sheet_title}</h1>
      <p class="name">${TEXT.learn.sheet_name}: ............................................ <span class="no">${sheet}</span></p>
      <ol>${exercises.map((e) => html`<li>${e.question}<div class="lines" aria-hidden="true"></div></li>`)}</ol>
      <section class="key"><h2>${TEXT.learn.sheet_key} <span class="no">${sheet}</span></h2><ol>${exercises.map((e) => html`<li>${e.answer}</li>`)}</ol>
      <p class="small">${TEXT.learn.sheet_for}</p></section>
      <p class="tools screen"><button type="button" class="main" @click=${() => print()}>${TEXT.learn.sheet_print}</button>
        <button type="button" @click=${() => page.set({ sheet: (sheet % 999999) + 1 })}>${TEXT.learn.sheet_new}</button>
        <a href="#v=1&scene=learn">${TEXT.learn.sheet_back}</a></p>
    </article>`;
  }
  return html`<h1>${TEXT.scenes["learn"]}</h1><p class="about">${TEXT.about["learn"]}</p>
    <ol class="stories">${STORIES.map((story) => html`<li><a href=${story.link}><b>${story.title}</b><span>${story.question}</span></a></li>`)}</ol>
    <p><a class="button" href="#v=1&scene=learn&sheet=1">${TEXT.learn.sheet}</a></p>`;
}
