// Greek letters as they are spoken, because few keyboards have them: "Λ z" is found as "lambda z".

const NAMES: Record<string, string> = {
  Φ: "phi", Λ: "lambda", λ: "lambda", σ: "sigma", δ: "delta", α: "alpha", ν: "nu", φ: "phi", θ: "theta", ψ: "psi",
};

/** The Greek letters of `label` by their names, the rest as it is, accents left out. */
export function spelled(label: string): string {
  const plain = label.normalize("NFD").replace(/\p{Mn}/gu, "").replace("₀", "0").replace("₁", "1").replace("₂", "2");
  return [...plain].map((letter) => NAMES[letter] ?? letter).join("");
}
