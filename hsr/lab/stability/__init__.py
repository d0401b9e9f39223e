"""Where the methods break: families of numerically hard cases, theory beside measurement.

A family (:mod:`hsr.lab.stability.family`) makes scenes that grow harder with one parameter, and
says of variants of the methods at which value of it they first show a wrong face, and why. The judge
(:mod:`hsr.lab.stability.judge`) runs them, lets exact arithmetic decide every sample, and compares
where they broke with where they should have. Each file of :mod:`hsr.lab.stability.cases` holds the families
of one theme; a new one is a function there that is called a hard case.
"""
