#!/usr/bin/env python3
"""Draws the report of `isocast accuracy`: FOLDER/results.json becomes FOLDER/report/index.html."""
# SPDX-License-Identifier: MPL-2.0
import html
import json
import math
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.image
import matplotlib.pyplot as plt
import matplotlib.ticker
import numpy

# Okabe and Ito's colours, which most eyes tell apart, and marks that printers do.
COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#8c564b"]
MARKS = "osD^vP*X"


def text_of(setting):
    return " ".join(f"{knob}={value}" for knob, value in setting.items()) or "as usual"


def number(value):
    if value == 0:
        return "0"
    return f"{value:.2g}" if 1e-3 <= abs(value) < 1000 else f"{value:.1e}"


def seconds(value):
    return f"{1000 * value:.0f} ms" if value < 1 else f"{value:.1f} s"


class Stage:
    """One plot: errors and prices of the settings of some knobs."""

    def __init__(self, stage, settings, diagonal):
        self.__dict__.update(stage)
        self.settings = settings
        self.errors = {i: settings[i]["errors"][self.error] for i in self.points}
        self.price_of = {i: price for i, price in zip(self.points, self.prices)}
        # World units mean something as a part of the whole.
        if self.unit == "world" and diagonal > 0:
            self.unit = "% of the diagonal"
            self.errors = {
                i: {key: e[key] * 100 / diagonal for key in ("rms", "max")}
                for i, e in self.errors.items()
            }

    def rms(self, i):
        return self.errors[i]["rms"]

    def seconds(self, i):
        return self.price_of[i][0]

    def floor(self):
        """Where errors of 0 are drawn: half the least other one."""
        others = [self.rms(i) for i in self.points if self.rms(i) > 0]
        return min(others) / 2 if others else 1e-9

    def family(self, i):
        """The knobs that a setting turns, of this stage: one colour each."""
        return " and ".join(self.settings[i]["setting"]) or "as usual"

    def label(self, i):
        """Of a point on the front; knobs that its family names are left out."""
        values = self.settings[i]["setting"].values()
        return ", ".join(values) if values else "as usual"


def draw(stage, path):
    figure, axes = plt.subplots(figsize=(8.2, 4.8), dpi=110)
    families = list(dict.fromkeys(stage.family(i) for i in stage.points))
    floor = stage.floor()
    height = lambda i: max(stage.rms(i), floor)
    front = stage.front
    # None is better below the stairs.
    if front:
        xs, ys = [], []
        for i in front:
            if ys:
                xs.append(stage.seconds(i))
                ys.append(ys[-1])
            xs.append(stage.seconds(i))
            ys.append(height(i))
        xs.append(max(stage.seconds(i) for i in stage.points) * 1.15)
        ys.append(ys[-1])
        axes.plot(xs, ys, color="#bbbbbb", linewidth=6, alpha=0.6, zorder=1,
                  solid_joinstyle="round", label="front: none is cheaper and better")
    for number_, family in enumerate(families):
        members = [i for i in stage.points if stage.family(i) == family]
        x = [stage.seconds(i) for i in members]
        low = [stage.seconds(i) - stage.price_of[i][1] for i in members]
        high = [stage.price_of[i][2] - stage.seconds(i) for i in members]
        axes.errorbar(x, [height(i) for i in members], xerr=[low, high], linestyle="none",
                      marker=MARKS[number_ % len(MARKS)], markersize=7, linewidth=0.8,
                      color=COLOURS[number_ % len(COLOURS)], label=family, zorder=2)
    for k, i in enumerate(front):
        axes.annotate(stage.label(i), (stage.seconds(i), height(i)), fontsize=8, fontweight="bold",
                      textcoords="offset points", xytext=(7, 7 if k % 2 == 0 else -13))
    others = [i for i in stage.points if i not in front]
    if len(others) <= 16:
        for i in others:
            axes.annotate(stage.label(i), (stage.seconds(i), height(i)), fontsize=7,
                          color="#777777", textcoords="offset points", xytext=(6, -9))
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.xaxis.set_major_locator(matplotlib.ticker.LogLocator(subs=(1, 2, 5)))
    axes.xaxis.set_major_formatter(lambda value, _: seconds(value))
    axes.xaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())
    axes.grid(True, which="major", color="#e4e4e4", zorder=0)
    axes.margins(x=0.12, y=0.12)
    axes.set_xlabel(f"{stage.price}  →  dearer")
    note = f"; 0 is drawn at {number(floor)}" if any(stage.rms(i) == 0 for i in stage.points) else ""
    axes.set_ylabel(f"rms error [{stage.unit}{note}]  →  worse", fontsize=9)
    axes.set_title(f"{stage.name}: {stage.what}", fontsize=10)
    axes.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)
    figure.savefig(path, bbox_inches="tight")
    plt.close(figure)


def verdicts(stage):
    """What each knob buys: (stage, knobs, ratio of errors, ratio of prices, best setting)."""
    rows = []
    families = dict.fromkeys(stage.family(i) for i in stage.points if stage.settings[i]["setting"])
    for family in families:
        members = [i for i in stage.points if stage.family(i) in (family, "as usual")]
        cheap = min(members, key=stage.seconds)
        best = min(members, key=lambda i: (stage.rms(i), stage.seconds(i)))
        worst = max(members, key=stage.rms)
        floor = stage.floor()
        rows.append((stage, family, max(stage.rms(worst), floor) / max(stage.rms(best), floor),
                     stage.seconds(best) / stage.seconds(cheap), best))
    return rows


def verdict(gain, cost):
    if gain < 1.05:
        return "<span class=waste>no effect here</span>"
    if cost < 1.15:  # what rounds differ by
        return "<span class=good>free</span>"
    if cost < math.sqrt(gain):
        return "<span class=good>cheap</span>"
    return "<span class=waste>dear</span>"


def waste(stage):
    """Settings that cost more than one that is as good, whatever the rounds: (stage, the setting,
    the one instead, ratio of prices)."""
    rows = []
    for i in stage.points:
        better = [j for j in stage.points
                  if stage.rms(j) <= stage.rms(i) and stage.price_of[j][2] < stage.price_of[i][1]]
        if better:
            j = min(better, key=stage.seconds)
            rows.append((stage, i, j, stage.seconds(i) / stage.seconds(j)))
    return rows


def draw_overview(rows, path):
    """Of each knob a bar for what it buys and one for what it costs."""
    figure, axes = plt.subplots(figsize=(9, 0.6 + 0.42 * len(rows)), dpi=110)
    places = range(len(rows), 0, -1)
    axes.barh([y + 0.19 for y in places], [max(row[2], 1) - 1 for row in rows], 0.36, left=1,
              color="#009e73", label="error falls by")
    axes.barh([y - 0.19 for y in places], [max(row[3], 1) - 1 for row in rows], 0.36, left=1,
              color="#d55e00", label="for so much more time")
    axes.set_yticks(list(places), [f"{row[0].name}: {row[1]}" for row in rows], fontsize=8)
    axes.set_xscale("log")
    axes.set_xlim(left=1)
    axes.xaxis.set_major_formatter(lambda value, _: f"{value:,.0f}x")
    axes.grid(True, axis="x", color="#e4e4e4", zorder=0)
    axes.set_axisbelow(True)
    axes.legend(fontsize=8, loc="lower right")
    figure.savefig(path, bbox_inches="tight")
    plt.close(figure)


def needs(stage):
    """If you need X, set Y, pay Z: for each power of ten that something meets, the cheapest; only
    the strictest that a setting meets."""
    greatest = max(stage.rms(i) for i in stage.points)
    least = min((stage.rms(i) for i in stage.points if stage.rms(i) > 0), default=0)
    if least == 0:
        return []
    rows = {}
    for power in range(math.floor(math.log10(greatest)), math.floor(math.log10(least)) - 1, -1):
        meeting = [i for i in stage.points if stage.rms(i) <= 10.0**power]
        if meeting:
            rows[min(meeting, key=stage.seconds)] = 10.0**power
    return [(limit, i) for i, limit in rows.items()]


def table(head, rows):
    cells = lambda tag, row: "".join(f"<{tag}>{cell}</{tag}>" for cell in row)
    return (f"<table><tr>{cells('th', head)}</tr>"
            + "".join(f"<tr>{cells('td', row)}</tr>" for row in rows) + "</table>")


def difference(report, stage, results, worst, best):
    """The pictures of two settings, ten times as far apart; none if either is missing."""
    paths = [results["settings"][i].get("picture") for i in (worst, best)]
    if not all(paths):
        return None
    a, b = (matplotlib.image.imread(report.parent / path)[..., :3] for path in paths)
    name = f"difference-{stage.error}-{stage.name.replace(' ', '-')}.png"
    matplotlib.image.imsave(report / "pictures" / name,
                            numpy.clip(10 * numpy.abs(a - b), 0, 1))
    return f"pictures/{name}"


def figure(path, caption):
    return f'<figure><img src="{path}"><figcaption>{caption}</figcaption></figure>'


def picture_of(results, i):
    return results["settings"][i]["picture"].removeprefix("report/")


STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; max-width: 1080px; margin: 2em auto; color: #222 }
h1 { margin-bottom: 0 } h2 { margin-top: 2em; border-top: 2px solid #ddd; padding-top: .6em }
table { border-collapse: collapse; margin: .6em 0 } td, th { padding: .2em .8em; text-align: left;
border-bottom: 1px solid #e5e5e5 } th { background: #f4f4f4 } figure { display: inline-block;
margin: .4em; vertical-align: top; max-width: 260px } figure img { width: 256px }
figcaption { font-size: 12px; color: #555 } .plot { max-width: 100% } .waste { color: #b03000 }
.good { color: #00703c } small { color: #666 }
"""


def main(folder):
    folder = pathlib.Path(folder)
    results = json.loads((folder / "results.json").read_text())
    report = folder / "report"
    settings = results["settings"]
    stages = [Stage(stage, settings, results["diagonal_world"]) for stage in results["stages"]]
    out = [f"<!doctype html><meta charset=utf-8><title>isocast accuracy</title><style>{STYLE}"
           f"</style><h1>What accuracy costs: {html.escape(results['run']['input'])}</h1>"]
    size = "x".join(map(str, results["run"]["size"]))
    rounds = max((len(s["seconds"].get("frame", [])) for s in settings), default=0)
    out.append(f"<p><small>{len(settings)} settings at {size}, medians of {rounds} rounds in turn; "
               f"truth: {html.escape(results['truth'])}</small></p>")

    out.append("<h2>At a glance</h2>")
    bought = sorted((row for stage in stages for row in verdicts(stage)),
                    key=lambda row: -row[2] / row[3])
    draw_overview(bought, report / "overview.png")
    out.append('<img class=plot src="overview.png">')
    out.append(table(("error of", "knob", "error falls by", "time grows by", "best value", ""), [
        (stage.name, family, f"{number(gain)} times", f"{cost:.2g} times",
         html.escape(text_of(settings[best]["setting"])), verdict(gain, cost))
        for stage, family, gain, cost, best in bought]))
    wasted = sorted((row for stage in stages for row in waste(stage)), key=lambda row: -row[3])
    if wasted:
        out.append("<h2>Where money is wasted</h2>" + table(
            ("error of", "setting", "rms", "pays", "no worse", "rms", "for", ""), [
                (stage.name, f"<span class=waste>{html.escape(text_of(settings[i]['setting']))}"
                 "</span>", f"{number(stage.rms(i))} {stage.unit}", seconds(stage.seconds(i)),
                 f"<span class=good>{html.escape(text_of(settings[j]['setting']))}</span>",
                 number(stage.rms(j)), seconds(stage.seconds(j)), f"{ratio:.2g} times the price")
                for stage, i, j, ratio in wasted[:12]]))

    out.append("<h2>If you need X, set Y, pay Z</h2>")
    rows = []
    for stage in stages:
        for limit, i in needs(stage):
            rows.append((stage.name, f"{number(limit)} {stage.unit}",
                         html.escape(text_of(settings[i]["setting"])), seconds(stage.seconds(i)),
                         f"{number(stage.rms(i))} / {number(stage.errors[i]['max'])}"))
    out.append(table(("error of", "rms below", "set", "pay", "measured rms / max"), rows))

    for stage in stages:
        name = stage.name.replace(" ", "-")
        draw(stage, report / f"{name}.png")
        out.append(f'<h2>{stage.name.capitalize()}</h2><img class=plot src="{name}.png">')
        rows = []
        for i in sorted(stage.points, key=stage.seconds):
            least, greatest = stage.price_of[i][1:]
            mark = "<b>front</b>" if i in stage.front else ""
            counts = settings[i]["errors"][stage.error].get("pixels", {})
            rows.append((html.escape(text_of(settings[i]["setting"])), number(stage.rms(i)),
                         number(stage.errors[i]["max"]), seconds(stage.seconds(i)),
                         f"{seconds(least)} to {seconds(greatest)}",
                         ", ".join(f"{v} {k}" for k, v in counts.items() if v), mark))
        out.append("<details><summary>All settings</summary>" + table(
            ("setting", f"rms [{stage.unit}]", "max", "median", "rounds", "pixels", ""), rows)
                   + "</details>")
        shown = [i for i in stage.points if settings[i].get("picture")]
        if not shown or not stage.front:
            continue
        cheap, best = stage.front[0], stage.front[-1]
        worst = max(shown, key=stage.rms)
        for i, caption in ((cheap, "cheapest of the front"), (best, "most accurate"),
                           (worst, "worst")):
            if settings[i].get("picture"):
                out.append(figure(picture_of(results, i), f"{caption}: "
                                  f"{html.escape(text_of(settings[i]['setting']))}, "
                                  f"{number(stage.rms(i))} {stage.unit}"))
        if path := difference(report, stage, results, worst, best):
            out.append(figure(path, "worst against most accurate, differences times 10"))

    failed = [(html.escape(text_of(s["setting"])), html.escape(s["failed"]))
              for s in settings if s.get("failed")]
    if failed:
        out.append("<h2>Not measured</h2>" + table(("setting", "why"), failed))
    out.append("<h2>Machine</h2>" + table(("", ""), [
        (key, html.escape(str(value))) for key, value in results["machine"].items()]))
    out.append('<p><a href="../results.json">results.json</a>, '
               '<a href="../results.csv">results.csv</a></p>')
    (report / "index.html").write_text("\n".join(out))


if __name__ == "__main__":
    main(sys.argv[1])
