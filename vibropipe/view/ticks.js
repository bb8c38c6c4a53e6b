// Writes a tick in its shortest form, with few digits: 0.2, 40, 4e−5.
const plain = String(Number(tick.toPrecision(6)))
const short = Number(tick.toPrecision(6)).toExponential()
return (tick != 0 && short.length < plain.length ? short : plain).replace(/-/g, "−")
