"""Small studies of every kind of scene, as users write them: for tests of what any report must keep."""

HEAD = "title: A study of {}\nexciter: {{l: 0.5, nu: 1, f: -1, h: 0.2, R1: 0.7, R2: 0.7}}\n"
STUDIES = {
    "one_motion": HEAD.format("one motion")
    + """
scenes:
  forced: {kind: motion, exciter: {delta: 0.05}, settle_periods: 100, tau_end: 12.6,
           outputs: [motion, impacts, harmonics, stability, energy]}
""",
    "motions_and_response": HEAD.format("motions and a response")
    + """
description: Motions side by side and alone, and the response on which they lie.
scenes:
  rigid_supports: {kind: motion, title: Rigid supports, settle_periods: 100, tau_end: 12.6,
                   figure: {together: [soft_supports, with_friction]},
                   outputs: [motion, impacts, harmonics, stability]}
  soft_supports: {kind: motion, title: Soft supports, exciter: {k1: 200, k2: 200, R1: 1, R2: 1, h1: 3, h2: 3},
                  settle_periods: 100, tau_end: 12.6, outputs: [motion, impacts, harmonics, stability]}
  with_friction: {kind: motion, exciter: {friction: 0.15}, settle_periods: 60, tau_end: 12.6,
                  outputs: [motion, impacts, harmonics, stability]}
  at_rest_at_times: {kind: motion, exciter: {nu: 0.4, f: 0.8, h: 0.15, R1: 0.3, R2: 0.3}, settle_periods: 20,
                     tau_end: 31.5, outputs: [motion, impacts, harmonics, stability]}
  without_a_period: {kind: motion, exciter: {nu: 0.79, f: 1.67, h: 0.1, delta: 0.1, R1: 0.8, R2: 0.8},
                     settle_periods: 20, tau_end: 60, outputs: [motion, impacts, harmonics, stability, lyapunov],
                     figure: {pictures: [panels, section, portrait]}}
  free: {kind: backbone, title: Free motion, amplitude: {start: 0.01, stop: 1.5, points: 60}}
  response:
    kind: sweep
    title: Response over the frequency
    over: {nu: {start: 0.5, stop: 3, points: 51}, delta: [0, 0.05]}
    follow: {along: nu, direction: both}
    figure: {backbone: free}
""",
    "units": """title: An exciter in millimetres
physical: {m: 2 kg, C: 8 N/mm, H: 25 N s/m, F: 40 N, l: 8 mm}
exciter: {R1: 0.75, R2: 0.65}
question: Over which frequencies does the mass strike both supports?
hero: {scene: response, picture: bifurcation}
scenes:
  response:
    kind: sweep
    over: {omega: {start: 30 rad/s, stop: 120 rad/s, points: 46}, delta: [0 mm, 0.6 mm]}
    outputs: [harmonics, impacts, stability]
    figure: {pictures: [curves, bifurcation]}
  regimes:
    kind: sweep
    title: Regimes over frequency and amplitude
    over: {omega: {start: 30 rad/s, stop: 120 rad/s, points: 16}, F: {start: 4 N, stop: 60 N, points: 12}}
    outputs: [harmonics, impacts]
""",
    "three_parameters": HEAD.format("three parameters")
    + """
scenes:
  maps:
    kind: sweep
    title: Maps over frequency, amplitude and offset
    over: {nu: {start: 0.4, stop: 2, points: 20}, f: {start: 0.1, stop: 1.5, points: 16}, delta: [0, 0.05, 0.1]}
""",
    "chaos_and_failures": """title: Chaos, and rows without a result
exciter: {l: 0.5, f: 1.67, h: 0.1, delta: 0.1, R1: 0.8, R2: 0.8}
scenes:
  cascade:
    kind: sweep
    over: {nu: {start: 0.72, stop: 0.83, points: 56}}
    outputs: [harmonics, impacts, stability]
    figure: {pictures: [bifurcation, curves]}
""",
    "starts": """title: Motions that coexist
exciter: {l: 0.5, nu: 3.48, f: 0.7, h: 0.1, delta: 0.1, R1: 0.8, R2: 0.8}
scenes:
  starts: {kind: basins, title: Which start leads where, over: {x0: {start: -0.4, stop: 0.6, points: 30},
           v0: {start: -2, stop: 2, points: 30}}}
""",
    "branches_and_borders": HEAD.format("branches and their borders")
    + """
scenes:
  response:
    kind: branch
    title: Orbits over the frequency
    along: {nu: {from: 1, to: [0.6, 2.6]}}
  borders:
    kind: boundary
    title: Folds and grazings over frequency and amplitude
    of: [fold, grazing]
    over: {nu: [0.7, 1.5], f: [0.1, 1.0]}
    lines: 3
""",
    "wanted_mean": HEAD.format("a wanted mean displacement")
    + """
scenes:
  shifted:
    kind: design
    title: Mean displacement of 0.05
    exciter: {nu: 1}
    vary: {delta: [-0.3, 0.3], R2: [0.4, 0.9]}
    target: {displacement_mean: 0.05}
    tolerance: {R1: 0.003, R2: 0.003}
""",
    "checks": "title: Hard cases\nscenes:\n  cases: {kind: hard_cases, cases: [split, damping]}\n",
    "race": HEAD.format("accuracy")
    + """
scenes:
  race: {kind: accuracy, motions: {plain: {periods: 2}, unequal: {exciter: {R1: 0.5}, periods: 2}},
         methods: [crude, newmark, exact], steps_per_period: [16, 64, 256], repeats: 1}
""",
    "costs": HEAD.format("costs of effects")
    + """
scenes:
  costs: {kind: effects, motions: {plain: {periods: 4}, no_damping: {exciter: {h: 0}, periods: 4}},
          repeats: 3}
""",
}
