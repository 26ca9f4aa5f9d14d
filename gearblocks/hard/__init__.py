"""Hard cases: trains that ordinary scripts break on, each with what must hold and the check of it.

`cases.json` has the words: model, what a naive script does wrong, what must hold, the criterion, and how three solvers of
scipy fared on the natural script (rtol 1e-6, at most 150,000 calls). The modules build and judge the cases; `suite`
puts both together. Defaults throughout: no case tunes the solver, unless its words name a tolerance.
"""
